// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstddef>

namespace vdrive {

// Demand generator of an axis: plans the requested motion and follows the plan. It knows motion
// requests but no operating modes.

/// Plans again when `request` differs from the one in force; the same request changes nothing.
void plan(Drive& drive, const MotionRequest& request);

/// In a tick that crosses segments, loads the segment valid at `substep` into the lane. The end
/// time of the previous segment stays in place because `advance_demand`, which ends the tick, needs
/// it.
/// @return the sub-step up to which the segment is valid, at most the number of sub-steps.
std::size_t cross_segments(Drive& drive, std::size_t substep);

/// Advances the demand to the end of the tick and, at the end of a profile, updates the target
/// state.
void advance_demand(Drive& drive);

}  // namespace vdrive
