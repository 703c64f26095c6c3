// SPDX-License-Identifier: Apache-2.0
#include "plan_watch.hpp"

#include <cstddef>
#include <utility>

namespace vdrive::ros2 {

void PlanWatch::warn(const BenchNow& now, std::size_t place, const std::string& text) {
  reports_.report(bridge::Severity::warning, now.bench.joints()[place].label(), text);
}

BrokenTrajectories PlanWatch::drop(const std::string& reason) {
  BrokenTrajectories broken;
  for (JointPlan& plan : plans_) {
    if (plan.trajectory() != 0) broken.push_back({.number = plan.trajectory(), .reason = reason});
    plan = {};
  }
  stream_.clear();
  return broken;
}

BrokenTrajectories PlanWatch::check(const BenchNow& now) {
  check_commands(now);
  auto broken = catch_up(now);
  check_ends(now);
  return broken;
}

void PlanWatch::check_commands(const BenchNow& now) {
  if (command_timeout_ <= 0.0) return;
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (plans_[i].duty() == Duty::none) continue;
    const bool ran = stream_.is_running();
    if (!plans_[i].brake_without_command(now.joint(i), command_timeout_)) continue;
    if (!ran && stream_.is_running()) stream_.begin(now.tick());
    warn(now, i, "no command for " + text_of(command_timeout_) + " s: it brakes");
  }
}

/// A bench that has passed the last set-point that it received stays at it: what follows starts
/// there.
BrokenTrajectories PlanWatch::catch_up(const BenchNow& now) {
  BrokenTrajectories broken;
  if (!stream_.is_running() || now.tick() <= stream_.sent_until()) return broken;
  const std::string reason = now.bench.label() + " was " +
                             std::to_string(now.tick() - stream_.sent_until()) +
                             " ticks ahead of its set-points";
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (!plans_[i].streams()) continue;
    const std::uint64_t number = plans_[i].start_again(now.joint(i));
    if (number != 0) broken.push_back({.number = number, .reason = reason});
  }
  stream_.catch_up(now.tick());
  return broken;
}

/// A bench that is late to receive the last set-points of a motion refuses them, and the drive
/// stays before its goal: it gets them again.
void PlanWatch::check_ends(const BenchNow& now) {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (plans_[i].duty() == Duty::none) continue;
    const JointNow joint = now.joint(i);
    const JointPlan::End end = plans_[i].check_end(joint);
    if (end == JointPlan::End::given_up) {
      warn(now, i, "the drive does not take its last set-point");
    } else if (end == JointPlan::End::refused) {
      stream_.lengthen();
      if (!stream_.is_running()) stream_.begin(now.tick());
      plans_[i].repeat_end(joint);
    }
  }
}

}  // namespace vdrive::ros2
