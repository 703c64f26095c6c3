// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint_limits.hpp"

namespace vdrive::ros2 {

/// Follows single positions along straight lines from one to the next, within the limits of speed
/// and acceleration, so that it never jumps. Stays at the last one.
class JointTracker {
 public:
  /// @param start motion of the joint
  explicit JointTracker(const JointMotion& start) noexcept
      : now_{start.position, start.velocity, 0.0},
        reference_(start.position),
        goal_(start.position) {}

  /// @param goal [rad or m]
  /// @param over [s] time in which the line reaches the goal
  void go_to(double goal, double over) noexcept {
    goal_ = goal;
    left_ = over;
  }

  /// Brakes to rest as quickly as the limits permit.
  void stop(const JointLimits& limits) noexcept;

  /// @param period [s] elapsed time, above 0
  /// @param limits only velocity and ramp are used; both above 0
  JointMotion step(double period, const JointLimits& limits) noexcept;

  [[nodiscard]] bool is_at_rest() const noexcept {
    return now_.position == goal_ && now_.velocity == 0.0;
  }

  [[nodiscard]] const JointMotion& now() const noexcept { return now_; }

  /// @return the goal [rad or m]
  [[nodiscard]] double goal() const noexcept { return goal_; }

 private:
  JointMotion now_;
  double reference_;  ///< on the line to the goal
  double goal_;
  double left_ = 0.0;  ///< [s] until the reference is at the goal
};

/// Follows single velocities or efforts along straight lines from one to the next, within a slope,
/// so that it never jumps. Stays at the last one.
class ValueLine {
 public:
  explicit ValueLine(double start) noexcept : now_(start), goal_(start) {}

  /// @param over [s] time in which the line reaches the goal
  void go_to(double goal, double over) noexcept {
    goal_ = goal;
    left_ = over;
  }

  /// @param period [s] elapsed time, above 0
  /// @param slope largest change of the value per second, above 0
  double step(double period, double slope) noexcept;

  [[nodiscard]] bool is_at_goal() const noexcept { return now_ == goal_; }

 private:
  double now_;
  double goal_;
  double left_ = 0.0;  ///< [s] until the line is at the goal
};

}  // namespace vdrive::ros2
