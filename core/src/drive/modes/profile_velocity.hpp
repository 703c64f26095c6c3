// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Profile velocity (6061h = 3): 60FFh with ramps; the position loop is open.
extern const Mode kProfileVelocity;

}  // namespace vdrive
