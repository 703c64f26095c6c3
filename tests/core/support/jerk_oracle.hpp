// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/motion/jerk_profile.hpp"

#include <array>
#include <cstddef>

namespace vdrive::test {

/// A state in long double; `way` is measured from the start of the motion [user units].
struct ExactState {
  long double way = 0.0L;
  long double velocity = 0.0L;
  long double acceleration = 0.0L;
};

/// Motion at constant jerk.
struct ExactPhase {
  ExactState begin;
  long double duration = 0.0L;  ///< [s]
  long double jerk = 0.0L;      ///< [user units/s³]

  /// @return the state `time` [s] after the beginning.
  [[nodiscard]] ExactState after(long double time) const;
};

/// Phases one after the other.
class ExactPath {
 public:
  explicit ExactPath(const ExactState& start) : end_(start) {}

  void add(long double duration, long double jerk);

  [[nodiscard]] std::size_t size() const { return count_; }

  [[nodiscard]] const ExactPhase& phase(std::size_t i) const { return phases_.at(i); }

  [[nodiscard]] long double duration() const { return duration_; }

  [[nodiscard]] const ExactState& end() const { return end_; }

  /// Replaces the velocity and the acceleration at the end, which rounding has changed.
  void settle_at(long double velocity, long double acceleration);

 private:
  std::array<ExactPhase, 16> phases_{};
  std::size_t count_ = 0;
  long double duration_ = 0.0L;
  ExactState end_;
};

/// @return the velocity at which the acceleration reaches 0 if it is reduced from now on.
[[nodiscard]] long double settled_velocity(const ExactState& state, const MotionJerk& jerk);

/// @return the fastest change to the velocity `target`: at each velocity on the way it has the
///         largest a²/2 that every bound allows. Uses none of the planner's case distinctions.
[[nodiscard]] ExactPath fastest_change(const ExactState& start, long double target,
                                       const MotionLimits& limits, const MotionJerk& jerk);

/// @return the time of the fastest motion over `distance` to rest, among those that head for +V or
///         -V for some time and then stop: tries both directions, and each instant from which a
///         stop ends at `distance`.
[[nodiscard]] long double fastest_move(const ExactState& start, long double distance,
                                       const MotionLimits& limits, const MotionJerk& jerk);

}  // namespace vdrive::test
