// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Interpolated position (6061h = 7): records of 60C1h:01, one every 60C2h, joined by straight
/// lines and buffered in 60C4h.
extern const Mode kInterpolatedPosition;

}  // namespace vdrive
