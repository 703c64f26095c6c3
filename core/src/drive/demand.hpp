// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/drive.hpp"

namespace vdrive {

// Demand generator and set-points of an axis.

/// Positions further from 0 than this (2⁴⁰) call for `rebase`.
inline constexpr double kFrame = 1099511627776.0;

/// The demand rests at `position` [UU].
void rest_at(const DriveContext& axis, double position);

/// How far the frames of positions move [UU].
struct FrameShift {
  double motor = 0.0;    // encoder 1
  double load = 0.0;     // the load itself
  double reading = 0.0;  // encoder of the position loop, demand and target
};

/// Counts every position from a place that lies `shift` further on; nothing moves.
void shift_frame(const DriveContext& axis, const FrameShift& shift);

/// Positions live in a frame that is kept near the 32-bit range: whole turns of the register are
/// taken out, which is exact, so no position grows with the uptime. A plan of before is void.
void rebase(const DriveContext& axis);

/// Plans anew when what is asked for has changed; the same request changes no bit.
void replan(const DriveContext& axis);

/// Demand at the end of a tick; what the end of a profile means for the target.
void advance_demand(const DriveContext& axis);

/// @return whether `set_point` may start now: a synchronous move (5E10h) only from rest, and within
///         607Fh, 6080h, 60C5h and 60C6h.
[[nodiscard]] bool can_start(const DriveContext& axis, const SetPoint& set_point);

/// Makes `set_point` the active one; the plan follows with the next tick.
void start_set_point(const DriveContext& axis, const SetPoint& set_point);

/// Forgets active and buffered set-points, a streamed target and a homing run.
void drop_set_points(const DriveContext& axis);

/// Forgets the set-points and takes the demand as the target: bit 10 at once, no jump.
void seed_target(const DriveContext& axis);

}  // namespace vdrive
