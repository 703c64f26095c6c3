// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

namespace vdrive {

// One tick of one axis, as steps in the order in which they happen. The bank goes through them for
// the axes of a block:
//   follow   automatic transitions, ends of stops, causes of faults, a change of the mode,
//            the next stage of the mode
//   ask      what state, mode and controlword request
//   plan     the demand generator, where the request has changed
//   sample   the demand at each sub-step     (sample_demand for the block, sample_across)
//   step     servo loops and plant           (the block)
//   watch    demand at the end of the tick, monitors, windows
//   take     the next set-point, where the active one is reached
//   show     the status image

/// What a tick of one axis asks of its block.
struct TickStart {
  bool across;   // the tick crosses a segment border: `sample_across` must be called
  bool general;  // the position loop is open: the block needs the general servo step
};

/// Follow, ask, plan; puts the segment in force into the block.
TickStart begin_tick(Drive& drive, DemandBlock& demand) noexcept;

/// Sample, for the lane of an axis whose tick crosses a segment border.
void sample_across(const Drive& drive, DemandBlock& demand) noexcept;

/// Watch, take, show.
void end_tick(Drive& drive) noexcept;

/// Shows without a tick, for an axis just powered up.
void show(Drive& drive) noexcept;

}  // namespace vdrive
