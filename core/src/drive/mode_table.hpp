// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

// The operating modes of the drive, and what asks for a motion before the mode in force does.

/// @return the mode in force, 6061h.
[[nodiscard]] const Mode& mode_of(const Drive& drive);

/// @return the motion that state, operating mode and controlword ask for now.
[[nodiscard]] MotionRequest requested_motion(const Drive& drive);

/// @return bits 10, 12 and 13 of 6041h, as far as the mode in force sets them.
[[nodiscard]] std::uint16_t mode_bits(const Drive& drive);

/// 6061h follows 6060h outside Operation enabled and at rest; a moving axis brakes first.
void follow_mode(Drive& drive);

}  // namespace vdrive
