// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Cyclic synchronous velocity (6061h = 9): 60FFh is streamed; the position loop is open.
extern const Mode kCyclicVelocity;

}  // namespace vdrive
