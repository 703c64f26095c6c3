// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstddef>

namespace vdrive {

// Demand generator of an axis: plans what is requested, and goes along the plan. It knows requests,
// not operating modes.

/// Plans anew when `request` differs from the one in force; the same request changes no bit.
void plan(Drive& drive, const MotionRequest& request);

/// For a tick that crosses segments: puts the one that holds at `substep` into the lane. The tick
/// ends with `advance_demand`, which needs the end of the segment of before: it stays.
/// @return the sub-step up to which the segment holds, at most the count of the tick.
std::size_t cross_segments(Drive& drive, std::size_t substep);

/// Goes to the end of the tick; what the end of a profile means for the target.
void advance_demand(Drive& drive);

}  // namespace vdrive
