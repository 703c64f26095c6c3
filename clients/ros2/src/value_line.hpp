// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::ros2 {

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
