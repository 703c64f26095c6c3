// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Cyclic synchronous torque (6061h = 10): 6071h is streamed; 607Fh and 6080h limit the speed.
extern const Mode kCyclicTorque;

}  // namespace vdrive
