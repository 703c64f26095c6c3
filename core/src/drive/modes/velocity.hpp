// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Velocity mode of inverters, vl (6061h = 2): 6042h in rpm with the ramps 6048h and 6049h, which
/// bits 4 to 6 of 6040h enable, unlock and feed; the position loop is open.
extern const Mode kVelocity;

}  // namespace vdrive
