// SPDX-License-Identifier: Apache-2.0
#include "churn/roles.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace vdrive::churn {
namespace {

using namespace std::chrono_literals;

/// Compares axes in steady motion with their expected position in each tick: 6062h(t) = 6062h(t0) +
/// 4 UU (t - t0), within 1 UU of rounding. A stopped axis violates that, as does a tick that was
/// numbered but not run (4 UU).
class SteadyMotion {
 public:
  explicit SteadyMotion(AxisRange range) : range_(range) {}

  /// @return whether the axes are at speed, from which time on they are judged.
  bool begin(const client::Observation& seen) {
    const bool moves = std::all_of(seen.axes.begin(), seen.axes.end(), [this](const auto& axis) {
      return !range_.contains(axis.id.axis) || axis.status.velocity_demand_value == kSteadySpeed;
    });
    if (moves) rebase(seen);
    return moves;
  }

  /// @return the deviation in this tick; std::nullopt if there is none.
  std::optional<std::string> judge(const client::Observation& seen) {
    std::size_t wrong = 0;
    std::string first;
    for (std::size_t place = 0; place < seen.axes.size(); ++place) {
      const client::AxisSnapshot& axis = seen.axes[place];
      if (!range_.contains(axis.id.axis)) continue;
      const auto passed = static_cast<std::int64_t>(seen.tick - tick_);
      const std::int64_t expected = demand_[place] + passed * kSteadySpeed / 1000;
      const std::int64_t off = axis.status.position_demand_value - expected;
      if (std::abs(off) <= 1) continue;
      if (wrong++ == 0) {
        first = "axis " + to_string(axis.id) + " is off by " + std::to_string(off) + " UU";
      }
    }
    if (wrong == 0) return std::nullopt;
    rebase(seen);
    return first + ", axes: " + std::to_string(wrong);
  }

 private:
  void rebase(const client::Observation& seen) {
    tick_ = seen.tick;
    demand_.clear();
    for (const auto& axis : seen.axes) demand_.push_back(axis.status.position_demand_value);
  }

  AxisRange range_;
  std::uint64_t tick_ = 0;
  std::vector<std::int64_t> demand_;
};

/// The counters of the stream.
struct Account {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t seen = 0;
  std::uint64_t missed = 0;      ///< numbered, but not received here
  std::uint64_t backwards = 0;   ///< ticks received twice or out of order
  std::uint64_t deviations = 0;  ///< ticks in which a steady axis was off its path

  void take(const client::Observation& seen_now) {
    if (first == 0) {
      first = seen_now.tick;
    } else {
      if (seen_now.tick <= last) {
        ++backwards;
      } else {
        missed += seen_now.tick - last - 1;
      }
    }
    last = seen_now.tick;
    ++seen;
  }

  void print_all(const char* what) const {
    print_line({{what, seen},
                {"missed", missed},
                {"backwards", backwards},
                {"deviations", deviations},
                {"first", first},
                {"last", last}});
  }
};

/// Judges each sample, from the first one that shows the moving axes at speed.
class Observer {
 public:
  explicit Observer(AxisRange steady) : motion_(steady) {}

  void observe(client::Follower& follower) {
    const auto seen = follower.next(500ms);
    if (!seen) {
      if (judges_) print_line({{"silent", to_string(seen.outcome().kind())}});
    } else if (judges_) {
      judge(*seen);
    } else if (motion_.begin(*seen)) {
      judges_ = true;
      print_line({{"watching", seen->axes.size()}});
      judge(*seen);
    }
  }

  [[nodiscard]] const Account& account() const noexcept { return account_; }

 private:
  void judge(const client::Observation& seen) {
    const bool is_report_due = pauses_.note();
    account_.take(seen);
    if (const auto wrong = motion_.judge(seen)) {
      ++account_.deviations;
      print_line({{"deviation", *wrong}, {"tick", seen.tick}});
    }
    if (is_report_due) account_.print_all("seen");
  }

  SteadyMotion motion_;
  Account account_;
  Pauses pauses_;
  bool judges_ = false;
};

std::vector<client::AxisId> all_axes(client::Session& session, std::uint32_t bench) {
  const auto info = session.find_bench(bench);
  std::vector<client::AxisId> axes;
  if (!info) {
    print_failure("observe", info.outcome());
    return axes;
  }
  for (const auto& axis : info->axes) axes.push_back(axis.id);
  return axes;
}

}  // namespace

int observe(const Setting& setting, AxisRange steady) {
  client::Session session(setting.network);
  const auto axes = all_axes(session, setting.bench);
  if (axes.empty()) return 1;
  auto follower = session.follow(axes, client::Pace::observe);
  if (!follower) {
    print_failure("follow", follower.outcome());
    return 1;
  }
  Observer observer(steady);
  // The same follower continues after a silence: an observer does not restart.
  while (!is_stop_requested()) observer.observe(*follower);
  observer.account().print_all("total");
  return 0;
}

}  // namespace vdrive::churn
