// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

namespace vdrive {

/// Drops active, buffered and streamed set-points and ends a homing run.
void drop_targets(Drive& drive);

/// Drops the targets and takes the demand as the target: bit 10 is set immediately and nothing
/// jumps.
void seed_target(Drive& drive);

}  // namespace vdrive
