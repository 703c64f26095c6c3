// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/block.hpp"
#include "drive/state.hpp"

namespace vdrive {

// One tick of one axis, as steps in the order of execution. The bank runs them for the axes of a
// block:
//   follow   automatic transitions, ends of stops, causes of faults, a change of mode,
//            the next stage of the mode
//   ask      the motion requested by state, mode and controlword
//   plan     the demand generator, if the request has changed
//   step     demand, servo loops and plant at each sub-step (the block)
//   watch    demand at the end of the tick, monitors, windows
//   take     the next set-point, if the active one is reached
//   show     the status image
// A lane is steady while it moves within a segment outside the target window, stands on its target,
// or has no power. The block computes the ticks of its steady lanes together, without these steps
// (drive/block.hpp), until something happens.

/// Steps follow, ask and plan.
void begin_tick(Drive& drive) noexcept;

/// Steps watch and take.
void watch_tick(Drive& drive) noexcept;

/// Simulates feedback that no longer arrives (5E0Ch): positions stay at the values in the status
/// image, velocities are 0, and errors are computed from these values. Loops, windows, limits and
/// switches do not use `numbers` and so still have the true feedback.
void freeze_feedback(const Drive& drive, NumberBlock& numbers) noexcept;

/// Step show, with the numbers of the block; also decides whether the next tick is steady.
void end_tick(Drive& drive, const NumberBlock& numbers) noexcept;

/// Makes the next tick of a steady lane run all steps.
void end_steadiness(Drive& drive) noexcept;

/// Updates the status image without a tick, for an axis just powered up.
void show(Drive& drive) noexcept;

}  // namespace vdrive
