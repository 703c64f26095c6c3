// SPDX-License-Identifier: Apache-2.0
#include "execution/command_progress.hpp"

#include "output/report.hpp"
#include "vdrive/quantity.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <utility>

namespace vdrive::tool {
namespace {

constexpr std::chrono::milliseconds kPeriodOfReports{250};

/// The newest states of axes, which it follows from the first call of text().
class NewestStates {
 public:
  using States = std::map<client::AxisId, client::AxisSnapshot>;

  NewestStates(client::Session& session, const std::vector<client::Axis>& axes)
      : session_(session) {
    ids_.reserve(axes.size());
    for (const client::Axis& axis : axes) ids_.push_back(axis.id());
  }

  /// @return the result of `look` for the states; empty before the first one has arrived.
  template <typename Look>
  std::string text(const Look& look) {
    follow();
    const std::scoped_lock lock(mutex_);
    return states_.empty() ? std::string() : look(states_);
  }

 private:
  /// If the axes cannot be followed there is no line: the command itself reports the failure.
  void follow() {
    if (std::exchange(is_followed_, true)) return;
    auto reports =
        session_.report_status(ids_, kPeriodOfReports, [this](const client::Observation& seen) {
          note(seen);
        });
    if (reports) reports_.emplace(std::move(*reports));
  }

  void note(const client::Observation& seen) {
    const std::scoped_lock lock(mutex_);
    for (const client::AxisSnapshot& axis : seen.axes) states_[axis.id] = axis;
  }

  client::Session& session_;
  std::vector<client::AxisId> ids_;
  bool is_followed_ = false;
  std::mutex mutex_;
  States states_;
  std::optional<client::StatusReports> reports_;  ///< destroyed before the members that it fills
};

/// @return the seconds since `start`, such as "12 s".
std::string time_since(std::chrono::steady_clock::time_point start) {
  const auto passed = std::chrono::steady_clock::now() - start;
  return std::to_string(std::chrono::duration_cast<std::chrono::seconds>(passed).count()) + " s";
}

std::string position_in(const client::Unit& unit, std::int32_t position) {
  return escaped(position_text(position, unit));
}

std::string velocity_in(const client::Unit& unit, std::int32_t velocity) {
  return position_in(unit, velocity) + std::string(unit_ending(Dimension::velocity));
}

// No line for shorter waits.
constexpr std::chrono::seconds kBeforeTheFirst{1};
constexpr std::chrono::milliseconds kBetween{250};

/// Rewrites the line until it is stopped.
void show(const std::stop_token& stop, const std::function<std::string()>& text,
          Terminal& terminal) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  const auto is_over_after = [&](std::chrono::milliseconds time) {
    // Only the stop wakes it.
    stopped.wait_for(lock, stop, time, [] {
      return false;
    });
    return stop.stop_requested();
  };
  for (bool is_over = is_over_after(kBeforeTheFirst); !is_over; is_over = is_over_after(kBetween)) {
    terminal.show_progress(text());
  }
}

}  // namespace

std::string motion_text(const client::AxisSnapshot& axis, const std::string& label,
                        const client::Unit& unit, std::optional<std::int32_t> target) {
  if (!target) return awaited_text(axis, label, unit, "moving");
  std::string text = "axis " + label + ": at " +
                     position_in(unit, axis.status.position_demand_value) + ", target " +
                     position_in(unit, *target) + ", " +
                     velocity_in(unit, axis.status.velocity_demand_value);
  if (const auto seconds = client::seconds_to(axis, *target)) {
    text += ", about " + std::to_string(*seconds) + " s left";
  }
  return text;
}

std::string awaited_text(const client::AxisSnapshot& axis, const std::string& label,
                         const client::Unit& unit, std::string_view what) {
  return "axis " + label + ": " + std::string(what) + ", at " +
         position_in(unit, axis.status.position_demand_value) + ", " +
         velocity_in(unit, axis.status.velocity_demand_value) + ", " +
         std::string(to_string(axis.state()));
}

std::string count_text(std::string_view what, std::size_t done, std::size_t all) {
  return std::string(what) + ": " + std::to_string(done) + " of " + counted(all, "axis", "axes");
}

void CommandProgress::motion(const client::Axis& axis, const std::string& label,
                             std::optional<std::int32_t> target) {
  const auto newest = std::make_shared<NewestStates>(session_, std::vector{axis});
  tell([newest, label, unit = axis.unit(), target] {
    return newest->text([&](const NewestStates::States& states) {
      return motion_text(states.begin()->second, label, unit, target);
    });
  });
}

void CommandProgress::axis(const client::Axis& axis, const std::string& label, std::string what) {
  const auto newest = std::make_shared<NewestStates>(session_, std::vector{axis});
  tell([newest, label, unit = axis.unit(), what = std::move(what)] {
    return newest->text([&](const NewestStates::States& states) {
      return awaited_text(states.begin()->second, label, unit, what);
    });
  });
}

void CommandProgress::axes(std::string what, const std::vector<client::Axis>& axes,
                           AxisTest is_done) {
  if (is_done == nullptr) {
    time(what + ", " + counted(axes.size(), "axis", "axes"));
    return;
  }
  const auto newest = std::make_shared<NewestStates>(session_, axes);
  tell([newest, what = std::move(what), all = axes.size(), is_done] {
    return newest->text([&](const NewestStates::States& states) {
      const auto done = std::ranges::count_if(states, [is_done](const auto& state) {
        return is_done(state.second);
      });
      return count_text(what, static_cast<std::size_t>(done), all);
    });
  });
}

void CommandProgress::time(std::string what) {
  tell([what = std::move(what), start = std::chrono::steady_clock::now()] {
    return what + ": " + time_since(start);
  });
}

void CommandProgress::tell(std::function<std::string()> text) {
  const bool is_shown = output_.terminal.shows_progress() && !output_.is_json && !output_.is_quiet;
  if (!is_shown) return;
  end();
  thread_ = std::jthread([this, text = std::move(text)](const std::stop_token& stop) {
    show(stop, text, output_.terminal);
  });
}

void CommandProgress::end() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  output_.terminal.end_progress();
}

}  // namespace vdrive::tool
