// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/motion/jerk_profile.hpp"
#include "vdrive/motion/profile.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

namespace vdrive::client {

/// The distance of one axis of a straight line, and its limits.
struct AxisDistance {
  double distance = 0.0;  ///< [UU] >= 0
  MotionLimits limits;
  MotionJerk jerk{};  ///< default: not limited, trapezoids
};

/// Common times of the axes of a line, as 5E10h takes them.
struct LineTimes {
  std::chrono::microseconds duration{0};
  std::chrono::microseconds acceleration{0};
  std::chrono::microseconds deceleration{0};
  std::chrono::microseconds jerk{0};  ///< at both ends of both ramps
};

/// Computes the shortest profile that all axes can share, in integer microseconds and ticks.
///
/// Along the path s = 0..1, an axis with the distance D and the limits v, a, d allows v/D, a/D and
/// d/D; the smallest of each applies. Without a cruise phase the peak is p² = 2ad/(a + d). Rounding
/// up makes the ramps and the duration longer, never an axis faster than its limits. If axes have
/// limited jerk, the smallest j/D applies as well: the acceleration of a ramp to the peak p builds
/// up for min(a/j, √(p/j)), a time that all axes share at both ends of both ramps and that
/// lengthens the ramps.
/// @return all 0 if no axis has a distance; nothing if an axis has a distance and must not move, or
///         if the duration exceeds the range of 5E10h, 2^32 - 1 us
[[nodiscard]] std::optional<LineTimes> plan_line(std::span<const AxisDistance> ways,
                                                 std::chrono::microseconds period);

/// Common times of a line that starts in motion, for distances `stretch` times as long.
struct MovingTimes {
  LineTimes times;
  std::uint32_t stretch = 1;
};

/// Computes times for 5E10h that encode the highest speed, ramps and jerk that all axes can share,
/// whatever their remaining distance and present speed. `ways` give only the proportions of the
/// line; they are stretched until the ramps to full speed fit, as far as the range of 5E10h:05
/// allows.
/// @param ways integers of at least 1 UU
/// @return nothing if plan_line() returns nothing for the stretched distances
[[nodiscard]] std::optional<MovingTimes> plan_moving_line(std::span<const AxisDistance> ways);

/// An upper bound for the duration of a line that starts in motion.
/// @param left the remaining distance as a fraction of the stretched distance, not negative
/// @param speed of the axes, in stretched distances per second, not negative
[[nodiscard]] std::chrono::microseconds longest_duration(const LineTimes& times, double left,
                                                         double speed) noexcept;

/// @return whether an axis that covers its distance in these times stays within its limits.
[[nodiscard]] bool keeps_limits(const AxisDistance& way, const LineTimes& times) noexcept;

}  // namespace vdrive::client
