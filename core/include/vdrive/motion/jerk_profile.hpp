// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/assert.hpp"
#include "vdrive/motion/profile.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace vdrive {

/// Limits on the rate of change of acceleration (60A3h, 60A4h): both > 0, or both 0 = unlimited.
struct MotionJerk {
  double acceleration = 0.0;  ///< [user units/s³] while speeding up
  double deceleration = 0.0;  ///< [user units/s³] while slowing down
};

/// @return whether `jerk` sets a limit.
[[nodiscard]] constexpr bool is_limited(const MotionJerk& jerk) noexcept {
  return jerk.acceleration > 0.0 && jerk.deceleration > 0.0;
}

/// Segment of constant jerk. With τ = t - reference_time [s]:
///   x(t) = position + (velocity + (acceleration/2 + jerk·τ/6)·τ)·τ
///   v(t) = velocity + (acceleration + jerk·τ/2)·τ
///   a(t) = acceleration + jerk·τ
/// The reference of the last segment of a motion to rest is its end (τ <= 0), so the end is exact.
struct JerkSegment {
  double end_time = 0.0;        ///< [s] since the plan; the segment is valid up to here
  double reference_time = 0.0;  ///< [s] since the plan
  double position = 0.0;        ///< [user units] at the reference
  double velocity = 0.0;        ///< [user units/s] at the reference
  double acceleration = 0.0;    ///< [user units/s²] at the reference
  double jerk = 0.0;            ///< [user units/s³]
};

/// @return a segment of constant acceleration as one with zero jerk.
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

/// @return the demand of a segment at `time` [s] since the plan.
[[nodiscard]] constexpr MotionSample sample(const JerkSegment& segment, double time) noexcept {
  constexpr double kSixth = 1.0 / 6.0;
  const double tau = time - segment.reference_time;
  const double jerk = segment.jerk;
  return {segment.position +
              (segment.velocity + (0.5 * segment.acceleration + (kSixth * jerk) * tau) * tau) * tau,
          segment.velocity + (segment.acceleration + (0.5 * jerk) * tau) * tau,
          segment.acceleration + jerk * tau};
}

/// A planned motion of limited jerk in closed form, with at most twelve segments (proof in
/// jerk_profile.cpp). Before time 0 it is at its start; after `duration()` it rests at its end.
class JerkProfile {
 public:
  static constexpr std::size_t kMaximumSegments = 12;

  /// A profile at rest at `position`.
  explicit constexpr JerkProfile(double position = 0.0) noexcept : end_position_(position) {}

  [[nodiscard]] std::size_t segment_count() const noexcept { return count_; }

  [[nodiscard]] const JerkSegment& segment(std::size_t i) const noexcept {
    ensure(i < count_, "a profile has the segment that is asked for");
    return segments_[i];
  }

  /// @return the time from the plan to standstill [s]; infinite for a motion that never ends.
  [[nodiscard]] double duration() const noexcept {
    return count_ == 0 ? 0.0 : segments_[count_ - 1].end_time;
  }

  /// @return the position at rest after the motion [user units].
  [[nodiscard]] double end_position() const noexcept { return end_position_; }

  /// @return false when the profile does not end at its target because the velocity limit is 0.
  [[nodiscard]] bool reaches_target() const noexcept { return reaches_target_; }

  /// @return the segment valid at `time` [s] since the plan; after the motion, an endless segment
  ///         at rest.
  [[nodiscard]] JerkSegment segment_at(double time) const noexcept;

  /// @return the demand at `time` [s] since the plan.
  [[nodiscard]] MotionSample at(double time) const noexcept;

 private:
  friend class JerkProfileBuilder;

  std::array<JerkSegment, kMaximumSegments> segments_{};
  double end_position_ = 0.0;
  std::uint8_t count_ = 0;
  bool reaches_target_ = true;
  // No uninitialised padding: snapshots contain these bytes.
  [[maybe_unused]] std::array<std::uint8_t, 6> unused_{};
};

// The functions below plan from any position, velocity and acceleration unless they say otherwise.
// `limits` bound the velocity, and the acceleration in the direction of motion to [-deceleration,
// acceleration]; where the direction changes, the smaller of the two applies. `jerk` (is_limited)
// bounds the rate of change of acceleration. Where the start is outside the limits, or leads out of
// them because the acceleration cannot end instantly, the motion returns to them as fast as the
// jerk allows, but does not reverse to do so. "Fastest" means the fastest of all motions if both
// jerks are equal. With two different jerks it means the fastest of the motions that never go
// backward, if start and target allow such a motion; one that backs up first could be faster. Where
// the axis must turn, a motion that overshoots more than necessary could be faster.

/// Plans the fastest motion to rest at `target` [user units]. If the velocity limit is 0, it brakes
/// to a standstill and stays there.
[[nodiscard]] JerkProfile plan_jerk_move(const MotionSample& start, double target,
                                         const MotionLimits& limits,
                                         const MotionJerk& jerk) noexcept;

/// @param limits peak velocity and accelerations of the move, from limits_of()
/// @return the jerk with which the acceleration of a move reaches its peaks in the jerk time of
///         `times`; unlimited if the jerk time or the distance is 0.
[[nodiscard]] MotionJerk jerk_of(const MotionLimits& limits, const MoveTimes& times) noexcept;

/// Plans the move from rest at `start` to rest at `target` [user units] that takes exactly these
/// times, with MoveTimes::jerk > 0, even over a distance of 0. Moves with the same times stay in
/// proportion to their displacements throughout and end together (5E10h).
[[nodiscard]] JerkProfile plan_timed_jerk_move(double start, double target,
                                               const MoveTimes& times) noexcept;

/// Plans the fastest change to the velocity `target` [user units/s], capped by `limits.velocity`,
/// which is then held forever. `end_position()` is meaningful only for a target of 0.
[[nodiscard]] JerkProfile plan_jerk_velocity(const MotionSample& start, double target,
                                             const MotionLimits& limits,
                                             const MotionJerk& jerk) noexcept;

/// Plans the fastest stop with `deceleration` [user units/s²] > 0. An axis that is speeding up gets
/// faster first. If the acceleration at the start carries the velocity through 0, the axis reverses
/// first and stops on the way back.
[[nodiscard]] JerkProfile plan_jerk_stop(const MotionSample& start, double deceleration,
                                         const MotionJerk& jerk) noexcept;

}  // namespace vdrive
