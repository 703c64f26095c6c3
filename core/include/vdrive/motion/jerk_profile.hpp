// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/assert.hpp"
#include "vdrive/motion/profile.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdrive {

/// How fast an acceleration may change (60A3h, 60A4h), both > 0, or both 0 = at once.
struct MotionJerk {
  double acceleration = 0.0;  ///< [user units/s³] while the speed grows
  double deceleration = 0.0;  ///< [user units/s³] while it shrinks
};

/// @return whether `jerk` limits anything.
[[nodiscard]] constexpr bool is_limited(const MotionJerk& jerk) noexcept {
  return jerk.acceleration > 0.0 && jerk.deceleration > 0.0;
}

/// Piece of constant jerk. With τ = t - reference_time [s]:
///   x(t) = position + (velocity + (acceleration/2 + jerk·τ/6)·τ)·τ
///   v(t) = velocity + (acceleration + jerk·τ/2)·τ
///   a(t) = acceleration + jerk·τ
/// The last piece of a motion to rest refers to its end (τ <= 0), so that the end is exact.
struct JerkSegment {
  double end_time = 0.0;        ///< [s] since the plan; the piece holds up to here
  double reference_time = 0.0;  ///< [s] since the plan
  double position = 0.0;        ///< [user units] at the reference
  double velocity = 0.0;        ///< [user units/s] at the reference
  double acceleration = 0.0;    ///< [user units/s²] at the reference
  double jerk = 0.0;            ///< [user units/s³]
};

/// @return a piece of constant acceleration as one without jerk.
[[nodiscard]] constexpr JerkSegment with_jerk(const Segment& segment) noexcept {
  return {.end_time = segment.end_time,
          .reference_time = segment.reference_time,
          .position = segment.position,
          .velocity = segment.velocity,
          .acceleration = segment.acceleration};
}

[[nodiscard]] constexpr JerkSegment with_jerk(const JerkSegment& segment) noexcept {
  return segment;
}

/// @return the demand of one segment at `time` [s] since the plan.
[[nodiscard]] constexpr MotionSample sample(const JerkSegment& segment, double time) noexcept {
  constexpr double kSixth = 1.0 / 6.0;
  const double tau = time - segment.reference_time;
  const double jerk = segment.jerk;
  return {segment.position +
              (segment.velocity + (0.5 * segment.acceleration + (kSixth * jerk) * tau) * tau) * tau,
          segment.velocity + (segment.acceleration + (0.5 * jerk) * tau) * tau,
          segment.acceleration + jerk * tau};
}

/// A planned motion of limited jerk, closed-form in time: at most twelve segments (the proof stands
/// in jerk_profile.cpp). Before 0 it is at its start, after `duration()` it rests at its end.
class JerkProfile {
 public:
  static constexpr std::size_t kMaximumSegments = 12;

  /// A profile that rests at `position`.
  explicit constexpr JerkProfile(double position = 0.0) noexcept : end_position_(position) {}

  [[nodiscard]] std::size_t segment_count() const noexcept { return count_; }

  [[nodiscard]] const JerkSegment& segment(std::size_t i) const noexcept {
    ensure(i < count_, "a profile has the segment that is asked for");
    return segments_[i];
  }

  /// @return the time from the plan to rest [s]; infinite for a motion without end.
  [[nodiscard]] double duration() const noexcept {
    return count_ == 0 ? 0.0 : segments_[count_ - 1].end_time;
  }

  /// @return the position at rest after the motion [user units].
  [[nodiscard]] double end_position() const noexcept { return end_position_; }

  /// @return false when the profile ends elsewhere than at its target because the velocity limit
  ///         is 0.
  [[nodiscard]] bool reaches_target() const noexcept { return reaches_target_; }

  /// @return the segment that holds at `time` [s] since the plan; after the motion a resting one
  ///         without end.
  [[nodiscard]] JerkSegment segment_at(double time) const noexcept;

  /// @return the demand at `time` [s] since the plan.
  [[nodiscard]] MotionSample at(double time) const noexcept;

 private:
  friend class JerkProfileBuilder;

  std::array<JerkSegment, kMaximumSegments> segments_{};
  double end_position_ = 0.0;
  std::uint8_t count_ = 0;
  bool reaches_target_ = true;
  // No byte without a value: snapshots have this.
  [[maybe_unused]] std::array<std::uint8_t, 6> unused_{};
};

// The plans below begin at any position, velocity and acceleration. `limits` bound the velocity and
// the acceleration in the direction of motion to [-deceleration, acceleration], at a change of the
// direction to the smaller of both, `jerk` (is_limited) bounds its change. Where the start is
// outside of limits, or leads out of them because the acceleration cannot end at once, the motion
// comes back as fast as the jerk allows, without a reversal for that. "Fastest" is among all
// motions where both jerks are equal. With two it is among those that never go backward, where the
// start and the target allow one: a motion that takes a run-up could be earlier, and where the axis
// has to turn also one that overshoots more than it has to.

/// Plans the fastest motion to rest at `target` [user units]. With a velocity limit of 0 it brakes
/// to rest and stays there.
[[nodiscard]] JerkProfile plan_jerk_move(const MotionSample& start, double target,
                                         const MotionLimits& limits,
                                         const MotionJerk& jerk) noexcept;

/// @return the jerk of a move over a distance in `times` (MoveTimes::jerk), whose limits are
///         `limits_of` these times; not limited without a jerk time or without a distance.
[[nodiscard]] MotionJerk jerk_of(const MotionLimits& limits, const MoveTimes& times) noexcept;

/// Plans the move from rest at `start` to rest at `target` [user units] that takes exactly these
/// times, MoveTimes::jerk > 0 among them, also over no distance: moves with the same times keep the
/// proportions of their displacements all the way and end together (5E10h).
[[nodiscard]] JerkProfile plan_timed_jerk_move(double start, double target,
                                               const MoveTimes& times) noexcept;

/// Plans the fastest change to the velocity `target` [user units/s], capped by `limits.velocity`,
/// which is then kept without end: `end_position()` means nothing unless the target is 0.
[[nodiscard]] JerkProfile plan_jerk_velocity(const MotionSample& start, double target,
                                             const MotionLimits& limits,
                                             const MotionJerk& jerk) noexcept;

/// Plans the fastest stop with `deceleration` [user units/s²] > 0. An axis that speeds up gets
/// faster first, one that is about to turn turns and stops on the way back.
[[nodiscard]] JerkProfile plan_jerk_stop(const MotionSample& start, double deceleration,
                                         const MotionJerk& jerk) noexcept;

}  // namespace vdrive
