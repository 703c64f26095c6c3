// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

namespace vdrive {

/// Forgets active and buffered set-points, streamed ones and a homing run.
void drop_targets(Drive& drive);

/// Forgets the targets and takes the demand as the target: bit 10 at once, no jump.
void seed_target(Drive& drive);

}  // namespace vdrive
