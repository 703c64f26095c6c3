// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// The frame that all positions of an axis count in, and the demand at rest in it.

/// Positions further from 0 than this (2⁴⁰) call for `rebase`.
inline constexpr double kFrame = 1099511627776.0;

/// Puts `segment` into the lane of the axis, from now on.
void put_segment(Drive& drive, const JerkSegment& segment);

/// @return the time of the end of the last tick since the plan [s].
[[nodiscard]] double plan_time(const Drive& drive);

/// @return the acceleration [UU/s²] with which a plan of limited jerk begins: that of the demand. A
///         motion without limited jerk, such as a stop that is cut short, hands over as much as is
///         within `limits` and can end by `jerk` before the speed is at its limit or 0.
[[nodiscard]] double starting_acceleration(const Drive& drive, const MotionLimits& limits,
                                           const MotionJerk& jerk);

/// The demand rests at `position` [UU].
void rest_at(Drive& drive, double position);

/// How far the frames of positions move [UU].
struct FrameShift {
  double motor = 0.0;    // encoder 1
  double load = 0.0;     // the load itself
  double reading = 0.0;  // encoder of the position loop, demand and target
};

/// Counts every position from a place that lies `shift` further on; nothing moves.
void shift_frame(Drive& drive, const FrameShift& shift);

/// Positions live in a frame that is kept near the 32-bit range: whole turns of the register are
/// taken out, which is exact, so no position grows with the uptime. A plan of before is void. On a
/// modulo axis they are whole ranges 607Bh: behind it the demand is inside of the range.
void rebase(Drive& drive);

[[nodiscard]] inline bool is_modulo(const Drive& drive) {
  return drive.registers().range.span > 0.0;
}

/// @return `position` [UU] as 6062h and 6064h show it: whole, modulo 2³², on a modulo axis from
///         607Bh:01 to below 607Bh:02.
[[nodiscard]] std::int32_t shown_position(const Drive& drive, double position);

/// @return the whole distance `distance` [UU] by the shorter way round the register, on a modulo
///         axis round its range; of two equal ones the positive one on a modulo axis.
[[nodiscard]] double shorter_way(const Drive& drive, double distance);

}  // namespace vdrive
