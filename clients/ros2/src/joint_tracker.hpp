// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint_limits.hpp"

namespace vdrive::ros2 {

/// Follows single positions in a straight line from one to the next, within the limits of speed and
/// acceleration, so that it never jumps. It rests at the last one.
class JointTracker {
 public:
  /// @param start where the joint is
  explicit JointTracker(const JointMotion& start) noexcept
      : now_{start.position, start.velocity, 0.0},
        reference_(start.position),
        goal_(start.position) {}

  /// @param goal [rad or m]
  /// @param over [s] time in which the line reaches it
  void go_to(double goal, double over) noexcept {
    goal_ = goal;
    left_ = over;
  }

  /// Brakes to rest, as soon as the limits permit.
  void stop(const JointLimits& limits) noexcept;

  /// @param period [s] that passes, above 0
  /// @param limits velocity and ramp count; both above 0
  JointMotion step(double period, const JointLimits& limits) noexcept;

  [[nodiscard]] bool is_at_rest() const noexcept {
    return now_.position == goal_ && now_.velocity == 0.0;
  }

  [[nodiscard]] const JointMotion& now() const noexcept { return now_; }

  /// @return [rad or m] where it goes
  [[nodiscard]] double goal() const noexcept { return goal_; }

 private:
  JointMotion now_;
  double reference_;  ///< on the line to the goal
  double goal_;
  double left_ = 0.0;  ///< [s] until the reference is at the goal
};

/// Follows single velocities or efforts in a straight line from one to the next, within a slope, so
/// that it never jumps. It stays at the last one.
class ValueLine {
 public:
  explicit ValueLine(double start) noexcept : now_(start), goal_(start) {}

  /// @param over [s] time in which the line reaches the goal
  void go_to(double goal, double over) noexcept {
    goal_ = goal;
    left_ = over;
  }

  /// @param period [s] that passes, above 0
  /// @param slope the most that the value changes in a second, above 0
  double step(double period, double slope) noexcept;

  [[nodiscard]] bool is_at_goal() const noexcept { return now_ == goal_; }

 private:
  double now_;
  double goal_;
  double left_ = 0.0;  ///< [s] until the line is at the goal
};

}  // namespace vdrive::ros2
