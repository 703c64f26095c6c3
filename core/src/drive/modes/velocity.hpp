// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Velocity mode of frequency inverters, vl (6061h = 2): 6042h in rpm with the ramps 6048h and
/// 6049h. Bits 4 to 6 of 6040h enable and unlock the ramp and connect its reference; the position
/// loop is open.
extern const Mode kVelocity;

}  // namespace vdrive
