// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Homing (6061h = 6) by the methods of `kHomingMethods`.
extern const Mode kHoming;

}  // namespace vdrive
