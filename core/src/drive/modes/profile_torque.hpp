// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Profile torque (6061h = 4): 6071h with the slope 6087h.
extern const Mode kProfileTorque;

}  // namespace vdrive
