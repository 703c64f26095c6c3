// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/block.hpp"
#include "drive/state.hpp"

namespace vdrive {

// One tick of one axis, as steps in the order in which they happen. The bank goes through them for
// the axes of a block:
//   follow   automatic transitions, ends of stops, causes of faults, a change of the mode,
//            the next stage of the mode
//   ask      what state, mode and controlword request
//   plan     the demand generator, where the request has changed
//   step     demand, servo loops and plant at each sub-step (the block)
//   watch    demand at the end of the tick, monitors, windows
//   take     the next set-point, where the active one is reached
//   show     the status image
// A steady lane is one whose next tick only advances in its segment: its ticks are done with those
// of the block (drive/block.hpp) until something happens. It moves within a segment outside of the
// target window, stands on its target, or has no power.

/// Follow, ask, plan.
void begin_tick(Drive& drive) noexcept;

/// Watch, take.
void watch_tick(Drive& drive) noexcept;

/// Feedback that does not arrive any more (5E0Ch): positions stay as the status image shows them,
/// velocities are 0, and the differences between demand and feedback are those of these values.
/// Loops, windows, limits and switches do not read `numbers`: they have the true feedback.
void freeze_feedback(const Drive& drive, NumberBlock& numbers) noexcept;

/// Show, with the numbers of the block; whether the next tick is a steady one.
void end_tick(Drive& drive, const NumberBlock& numbers) noexcept;

/// The next tick of a lane that was steady goes through the steps.
void end_steadiness(Drive& drive) noexcept;

/// Shows without a tick, for an axis just powered up.
void show(Drive& drive) noexcept;

}  // namespace vdrive
