// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Interpolated position (6061h = 7): records of 60C1h:01, one in each 60C2h, with straight lines
/// between them; 60C4h buffers them.
extern const Mode kInterpolatedPosition;

}  // namespace vdrive
