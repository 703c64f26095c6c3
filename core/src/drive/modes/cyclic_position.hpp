// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Cyclic synchronous position (6061h = 8): 607Ah is streamed.
extern const Mode kCyclicPosition;

}  // namespace vdrive
