// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// The frame of reference of all positions of an axis, and the demand at rest in it.

/// Positions further from 0 than this (2⁴⁰) require `rebase`.
inline constexpr double kFrame = 1099511627776.0;

/// Makes `segment` the one in force in the lane of the axis.
void put_segment(Drive& drive, const JerkSegment& segment);

/// @return the time from the plan to the end of the last tick [s].
[[nodiscard]] double plan_time(const Drive& drive);

/// @return the acceleration [UU/s²] with which a jerk-limited plan begins: the acceleration of the
///         demand. After a motion without limited jerk, such as an interrupted stop, it is reduced
///         until it is within `limits` and `jerk` can bring it to 0 before the speed reaches its
///         limit or 0.
[[nodiscard]] double starting_acceleration(const Drive& drive, const MotionLimits& limits,
                                           const MotionJerk& jerk);

/// Puts the demand at rest at `position` [UU].
void rest_at(Drive& drive, double position);

/// Displacement of the origins of the position frames [UU].
struct FrameShift {
  double motor = 0.0;    // encoder 1
  double load = 0.0;     // the load itself
  double reading = 0.0;  // encoder of the position loop, demand and target
};

/// Moves the origins of all positions by `shift`; the axis does not move.
void shift_frame(Drive& drive, const FrameShift& shift);

/// Keeps positions near the 32-bit range by subtracting multiples of the register range. This is
/// exact, and positions do not grow with uptime. On a modulo axis it subtracts multiples of the
/// range 607Bh, after which the demand is inside the range. The present plan becomes invalid.
void rebase(Drive& drive);

[[nodiscard]] inline bool is_modulo(const Drive& drive) {
  return drive.registers().range.span > 0.0;
}

/// @return `position` [UU] as 6062h and 6064h show it: a whole number, modulo 2³²; on a modulo axis
///         from 607Bh:01 up to but not including 607Bh:02.
[[nodiscard]] std::int32_t shown_position(const Drive& drive, double position);

/// @return `distance`, a whole number [UU], by the shorter way round the register or, on a modulo
///         axis, round its range. If both ways are equal, a modulo axis takes the positive one.
[[nodiscard]] double shorter_way(const Drive& drive, double distance);

}  // namespace vdrive
