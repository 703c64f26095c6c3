// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/motion/jerk_profile.hpp"
#include "vdrive/motion/profile.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

namespace vdrive::client {

/// What one axis of a straight line has to go, and what it may do on the way.
struct AxisWay {
  double distance = 0.0;  ///< [UU] >= 0
  MotionLimits limits;
  MotionJerk jerk{};  ///< not limited: trapezoids
};

/// Common times of the axes of a line, as 5E10h takes them.
struct LineTimes {
  std::chrono::microseconds duration{0};
  std::chrono::microseconds acceleration{0};
  std::chrono::microseconds deceleration{0};
  std::chrono::microseconds jerk{0};  ///< at both ends of both ramps
};

/// The shortest profile that all axes can share, in whole microseconds and whole ticks.
///
/// Along the path s = 0..1 an axis with the way D and the limits v, a, d allows v/D, a/D and d/D;
/// the smallest of each count. Without a cruise the peak is p² = 2ad/(a + d). Rounding up makes the
/// ramps and the duration longer, never an axis faster than its limits.
/// Where axes have limited jerk, the smallest of j/D counts as well: a ramp to the peak p grows for
/// min(a/j, √(p/j)), which all axes share at both ends of both ramps, and lasts as much longer.
/// @return all 0 when no axis has a way; nothing when one has a way and may not move, or when the
///         duration exceeds what 5E10h can hold, 2^32 - 1 us
[[nodiscard]] std::optional<LineTimes> plan_line(std::span<const AxisWay> ways,
                                                 std::chrono::microseconds period);

/// Common times of a line that starts in motion, of ways that are `stretch` times as long.
struct MovingTimes {
  LineTimes times;
  std::uint32_t stretch = 1;
};

/// Times from which the highest speed, ramps and jerk follow that all axes can share in any state,
/// as 5E10h:05 takes them: `ways` only have the proportions of the line, and are stretched until
/// the ramps to the full speed fit, as far as 5E10h:05 can hold them. The way that is left and the
/// speed of the axes do not count.
/// @param ways each whole and at least 1 UU
/// @return nothing where plan_line() of the stretched ways has nothing
[[nodiscard]] std::optional<MovingTimes> plan_moving_line(std::span<const AxisWay> ways);

/// An estimate from above of how long a line takes that starts in motion.
/// @param left of the way to the target, and `speed` [1/s], both in stretched ways and without a
///        sign
[[nodiscard]] std::chrono::microseconds longest_duration(const LineTimes& times, double left,
                                                         double speed) noexcept;

/// @return whether an axis that goes its way in these times stays within its limits.
[[nodiscard]] bool keeps_limits(const AxisWay& way, const LineTimes& times) noexcept;

}  // namespace vdrive::client
