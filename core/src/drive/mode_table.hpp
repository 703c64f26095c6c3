// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

// The operating modes of the drive, and what asks for a motion before the mode in force does.

/// @return the mode in force, 6061h.
[[nodiscard]] const Mode& mode_of(const Drive& drive);

/// @return the motion that state, operating mode and controlword ask for now.
[[nodiscard]] MotionRequest requested_motion(const Drive& drive);

/// 6061h follows 6060h outside Operation enabled and at rest; a moving axis brakes first.
void follow_mode(Drive& drive);

}  // namespace vdrive
