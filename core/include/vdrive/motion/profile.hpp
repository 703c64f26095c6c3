// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/assert.hpp"

#include <array>
#include <cstdint>

namespace vdrive {

/// Position and velocity of the demand at one instant.
struct MotionState {
  double position = 0.0;  ///< [user units]
  double velocity = 0.0;  ///< [user units/s]
};

/// Limits of a profile, all finite.
struct MotionLimits {
  double velocity = 0.0;      ///< [user units/s] >= 0; 0 = no motion
  double acceleration = 1.0;  ///< [user units/s²] > 0, speeding up
  double deceleration = 1.0;  ///< [user units/s²] > 0, slowing down
};

/// Segment of constant acceleration. With τ = t - reference_time [s]:
///   x(t) = position + (velocity + acceleration·τ/2)·τ
///   v(t) = velocity + acceleration·τ
/// The reference of the last segment of a move is its end (τ <= 0), so the end is exact.
struct Segment {
  double end_time = 0.0;        ///< [s] since the plan; the segment is valid up to here
  double reference_time = 0.0;  ///< [s] since the plan
  double position = 0.0;        ///< [user units] at the reference
  double velocity = 0.0;        ///< [user units/s] at the reference
  double acceleration = 0.0;    ///< [user units/s²]
};

/// The demand at one instant.
struct MotionSample {
  double position = 0.0;      ///< [user units]
  double velocity = 0.0;      ///< [user units/s]
  double acceleration = 0.0;  ///< [user units/s²]
};

/// @return the demand of a segment at `time` [s] since the plan.
[[nodiscard]] constexpr MotionSample sample(const Segment& segment, double time) noexcept {
  const double tau = time - segment.reference_time;
  return {segment.position + (segment.velocity + 0.5 * segment.acceleration * tau) * tau,
          segment.velocity + segment.acceleration * tau, segment.acceleration};
}

/// A planned motion in closed form, with at most four segments. Before time 0 it is at its start;
/// after `duration()` it rests at its end.
class Profile {
 public:
  static constexpr std::size_t kMaximumSegments = 4;

  /// A profile at rest at `position`.
  explicit constexpr Profile(double position = 0.0) noexcept : end_position_(position) {}

  [[nodiscard]] std::size_t segment_count() const noexcept { return count_; }

  [[nodiscard]] const Segment& segment(std::size_t i) const noexcept {
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
  [[nodiscard]] Segment segment_at(double time) const noexcept;

  /// @return the demand at `time` [s] since the plan.
  [[nodiscard]] MotionSample at(double time) const noexcept;

 private:
  friend class ProfileBuilder;

  std::array<Segment, kMaximumSegments> segments_{};
  double end_position_ = 0.0;
  std::uint8_t count_ = 0;
  bool reaches_target_ = true;
  // No uninitialised padding: snapshots contain these bytes.
  [[maybe_unused]] std::array<std::uint8_t, 6> unused_{};
};

/// Plans the time-optimal trapezoid from any state to rest at `target`. An axis above the velocity
/// limit first brakes to it; one that has passed its target, or cannot stop before it, first
/// brakes to a standstill. Speeding up uses `limits.acceleration`, slowing down
/// `limits.deceleration`. If the velocity limit is 0, the axis brakes to a standstill and stays
/// there.
///
/// With stopping distance s = v²/2d, displacement D >= s and v below the limit, the peak velocity
/// is v_p² = (2adD + dv²)/(a + d), capped by the limit.
[[nodiscard]] Profile plan_move(const MotionState& start, double target,
                                const MotionLimits& limits) noexcept;

/// Times of a move from rest to rest [s]: `duration` >= acceleration + deceleration > 0, and each
/// of these two >= 2·jerk.
struct MoveTimes {
  double duration = 0.0;
  double acceleration = 0.0;
  double deceleration = 0.0;
  /// Time in which the acceleration of each ramp builds up and again falls off; 0 = in one step.
  double jerk = 0.0;
};

/// @return the peak velocity and the peak accelerations of a move over `displacement` [user units]
///         in these times. The jerk time changes neither the peak velocity nor the distance covered
///         in a ramp, which is symmetric about its middle.
[[nodiscard]] MotionLimits limits_of(double displacement, const MoveTimes& times) noexcept;

/// Plans the trapezoid from rest at `start` to rest at `target` that takes exactly these times,
/// without a jerk time, even over a distance of 0. Moves with the same times stay in proportion to
/// their displacements throughout and end together (5E10h).
[[nodiscard]] Profile plan_timed_move(double start, double target, const MoveTimes& times) noexcept;

/// Plans the change to the velocity `target` [user units/s], capped by `limits.velocity`, which is
/// then held forever. `end_position()` is meaningful only for a target of 0. Speeding up uses
/// `limits.acceleration`, slowing down `limits.deceleration`; a change of sign uses both.
[[nodiscard]] Profile plan_velocity(const MotionState& start, double target,
                                    const MotionLimits& limits) noexcept;

/// Plans the stop from `start` with `deceleration` [user units/s²] > 0.
[[nodiscard]] Profile plan_stop(const MotionState& start, double deceleration) noexcept;

}  // namespace vdrive
