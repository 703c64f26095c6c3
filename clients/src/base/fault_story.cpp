// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/fault_story.hpp"

#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

namespace vdrive::client {
namespace {

using namespace literals;

constexpr ObjectAddress address_of(ObjectRow row) {
  return kObjectRows[static_cast<std::size_t>(row)].address;
}

constexpr ObjectAddress kDriveControlword = address_of("ds402_controlword"_object);
constexpr ObjectAddress kFollowingWindowObject = address_of("following_error_window"_object);
constexpr ObjectAddress kFollowingTimeObject = address_of("following_error_time_out"_object);
constexpr ObjectAddress kMaxTorqueObject = address_of("max_torque"_object);
constexpr ObjectAddress kLastTestInput = address_of("test_frozen_feedback"_object);
constexpr std::uint16_t kFirstTestInput = 0x5E00;

bool is_test_input(ObjectAddress object) {
  return object.index >= kFirstTestInput && object.index <= kLastTestInput.index;
}

/// The value of an object at the time of the cause.
struct Known {
  std::int64_t value = 0;
  std::optional<AxisWrite> write{};  ///< of the value; nothing: it predates the window
};

std::string hex_text(std::uint64_t number) {
  std::array<char, 20> text{};
  std::snprintf(text.data(), text.size(), "%04llXh",  // NOLINT(*-vararg)
                static_cast<unsigned long long>(number));
  return text.data();
}

class Story {
 public:
  Story(const Window& window, const WindowCause& cause, const BenchInfo& bench,
        const SessionText& name_of)
      : window_(window), cause_(cause), bench_(bench), name_of_(name_of) {
    std::uint64_t shown = 0;  // tick of the values, which include all earlier writes
    for (const WindowValue& value : window.values) {
      if (value.axis != cause.axis || value.tick > cause.tick) continue;
      known_[value.object] = {.value = value.value};
      shown = value.tick;
    }
    for (const AxisWrite& write : window.writes) {
      const bool is_before = write.tick >= shown && write.tick < cause.tick;
      if (write.axis == cause.axis && is_before && write.reason == 0) take(write);
    }
    for (const Observation& sample : window.samples) {
      if (sample.tick > cause.tick) break;
      const auto axis = std::ranges::find_if(sample.axes, [&](const AxisSnapshot& each) {
        return each.id.axis == cause.axis;
      });
      if (axis != sample.axes.end()) before_.push_back(&*axis);
    }
  }

  FaultStory tell() {
    FaultStory story{.title = title(), .lines = {}, .remedy = {}};
    if (cause_.kind == WindowCause::Kind::fault) {
      story.remedy = remedy_of(static_cast<ErrorCode>(cause_.code));
    }
    add_inputs();
    add_limit(kFollowingWindowObject, "the following error (60F4h)", "UU",
              [](const AxisStatus& status) {
                return std::int64_t{status.load_position_error_value};
              });
    add_limit(kMaxTorqueObject, "the torque (6077h)", "per mille of the rated torque",
              [](const AxisStatus& status) {
                return std::int64_t{status.torque_actual_value};
              });
    add_silence();
    add_command();
    add_state();
    add_others();
    story.lines = std::move(lines_);
    return story;
  }

 private:
  void take(const AxisWrite& write) {
    if (write.kind == AxisWrite::Kind::write) {
      known_[write.object] = {.value = write.value, .write = write};
    } else if (write.kind == AxisWrite::Kind::connection_loss) {
      lost_at_ = write.tick;
    } else if (write.kind == AxisWrite::Kind::power_cycle) {
      // Test-bench inputs keep their values; those of the other objects are no longer known.
      std::erase_if(known_, [](const auto& known) {
        return !is_test_input(known.first);
      });
    }
  }

  [[nodiscard]] std::string title() const {
    std::string text = cause_.axis == 0 ? "bench " + std::to_string(bench_.number)
                                        : "axis " + std::to_string(bench_.number) + "." +
                                              std::to_string(cause_.axis);
    text += ": ";
    if (cause_.kind == WindowCause::Kind::fault) {
      text +=
          hex_text(cause_.code) + " " + std::string(describe(static_cast<ErrorCode>(cause_.code)));
    } else {
      text += to_string(cause_.kind);
      if (cause_.session != 0) text += ", " + name_of_(cause_.session);
    }
    return text + " at tick " + std::to_string(cause_.tick);
  }

  /// @return a text such as "31 ms", or "1.204 s" from one second on.
  [[nodiscard]] std::string time_text(std::uint64_t ticks) const {
    const std::chrono::duration<double> time(std::chrono::duration<double>(bench_.period).count() *
                                             static_cast<double>(ticks));
    std::array<char, 32> text{};
    if (time.count() < 1.0) {
      std::snprintf(text.data(), text.size(), "%.4g ms", time.count() * 1e3);  // NOLINT(*-vararg)
    } else {
      std::snprintf(text.data(), text.size(), "%.3f s", time.count());  // NOLINT(*-vararg)
    }
    return text.data();
  }

  [[nodiscard]] std::string before_text(std::uint64_t tick) const {
    return "tick " + std::to_string(tick) + ", " + time_text(cause_.tick - tick) + " before";
  }

  [[nodiscard]] std::string writer_text(const AxisWrite& write) const {
    if (write.means == AxisWrite::Means::bench) return "by the bench as it shut down";
    return write.session == 0 ? "by a program without a session" : "by " + name_of_(write.session);
  }

  /// Adds the test-bench inputs that were not 0 at the time of the cause.
  void add_inputs() {
    for (const auto& [object, known] : known_) {
      if (!is_test_input(object) || known.value == 0) continue;
      std::string line = "the test-bench input " + object_text(object) + " was set to " +
                         std::to_string(known.value);
      line += known.write
                  ? " at " + before_text(known.write->tick) + ", " + writer_text(*known.write)
                  : " before this window began";
      lines_.push_back(std::move(line));
    }
  }

  /// Adds how long a value was beyond its limit up to the cause.
  template <typename ValueOf>
  void add_limit(ObjectAddress limit, std::string_view what, std::string_view unit,
                 ValueOf value_of) {
    const auto known = known_.find(limit);
    if (known == known_.end() || known->second.value <= 0 || before_.size() < 2) return;
    const auto is_beyond = [&](const AxisSnapshot* axis) {
      return std::abs(value_of(axis->status)) >= known->second.value;
    };
    // The status with the fault may already show the effect of the fault reaction, so it counts
    // only if it is still beyond the limit.
    auto last = before_.rbegin() + (is_beyond(before_.back()) ? 0 : 1);
    auto first = last;
    while (first != before_.rend() && is_beyond(*first)) ++first;
    if (first == last) return;
    const std::uint64_t begin = (*(first - 1))->tick;
    std::string line = std::string(what) + " reached " + object_text(limit) + " = " +
                       std::to_string(known->second.value) + " " + std::string(unit) + " at " +
                       before_text(begin);
    if (const auto time = known_.find(kFollowingTimeObject);
        limit == kFollowingWindowObject && time != known_.end()) {
      line += "; " + object_text(kFollowingTimeObject) + " allows " +
              std::to_string(time->second.value) + " ms";
    }
    lines_.push_back(std::move(line));
  }

  void add_silence() {
    if (!lost_at_) return;
    std::string line = "its master";
    const auto event = std::ranges::find_if(window_.events, [this](const WindowEvent& each) {
      return each.kind == EventKind::master_lost && each.tick == *lost_at_;
    });
    if (event != window_.events.end()) line += ", " + name_of_(event->session) + ",";
    lines_.push_back(line + " fell silent and was considered lost at " + before_text(*lost_at_));
  }

  void add_command() {
    const auto word = known_.find(kDriveControlword);
    if (word == known_.end()) return;
    std::string line =
        "the last controlword was " + hex_text(static_cast<std::uint64_t>(word->second.value));
    line += word->second.write ? ", at " + before_text(word->second.write->tick) + ", " +
                                     writer_text(*word->second.write)
                               : ", from before this window";
    lines_.push_back(std::move(line));
  }

  /// Adds the state in the last tick before the cause.
  void add_state() {
    if (before_.size() < 2) return;
    const AxisSnapshot& axis = **(before_.rbegin() + 1);
    const OperatingModeRow* const mode = find_operating_mode(axis.mode());
    std::string line = "one tick earlier it was in " + std::string(to_string(axis.state()));
    if (mode != nullptr) line += ", " + std::string(mode->name);
    line += ", at " + std::to_string(axis.status.load_position_actual_value) + " UU with " +
            std::to_string(axis.status.load_velocity_actual_value) + " UU/s, " +
            std::to_string(axis.status.velocity_demand_value) + " demanded";
    lines_.push_back(std::move(line));
  }

  void add_others() {
    const std::size_t others = window_.kept.causes.size() + window_.kept.more_causes - 1;
    if (others == 0) return;
    lines_.push_back("the same window has " + std::to_string(others) +
                     (others == 1 ? " further cause" : " further causes"));
  }

  const Window& window_;
  const WindowCause& cause_;
  const BenchInfo& bench_;
  const SessionText& name_of_;
  std::map<ObjectAddress, Known> known_;     ///< at the time of the cause
  std::vector<const AxisSnapshot*> before_;  ///< up to the tick of the cause
  std::optional<std::uint64_t> lost_at_;     ///< the tick in which its master was considered lost
  std::vector<std::string> lines_;
};

}  // namespace

FaultStory story_of(const Window& window, const WindowCause& cause, const BenchInfo& bench,
                    const SessionText& name_of) {
  return Story(window, cause, bench, name_of).tell();
}

}  // namespace vdrive::client
