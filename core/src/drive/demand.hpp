// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstddef>

namespace vdrive {

// Demand generator of an axis: plans what is requested, and goes along the plan. It knows requests,
// not operating modes.

/// Plans anew when `request` differs from the one in force; the same request changes no bit.
void plan(Drive& drive, const MotionRequest& request);

/// @return whether the present tick crosses a border between two segments of the profile.
[[nodiscard]] inline bool crosses_segments(const Drive& drive) {
  const DemandState& own = drive.state().demand;
  const TickTiming& timing = drive.timing();
  const double first = own.plan_ticks * timing.substeps;
  return (first + (timing.substeps - 1.0)) * timing.substep >= own.segment.end_time;
}

/// Puts the segment in force into the lane of the block.
inline void put_segment(const Drive& drive, DemandBlock& demand) {
  const DemandState& own = drive.state().demand;
  const std::size_t l = drive.lane();
  demand.position[l] = own.segment.position;
  demand.velocity[l] = own.segment.velocity;
  demand.acceleration[l] = own.segment.acceleration;
  demand.reference_time[l] = own.segment.reference_time;
  demand.first_substep[l] = own.plan_ticks * drive.timing().substeps;
}

/// Samples the whole profile for the lane, for a tick that crosses segments.
void sample_profile(const Drive& drive, DemandBlock& demand);

/// Goes to the end of the tick; what the end of a profile means for the target.
void advance_demand(Drive& drive);

}  // namespace vdrive
