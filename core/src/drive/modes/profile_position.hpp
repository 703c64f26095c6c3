// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

namespace vdrive {

/// Profile position (6061h = 1): set-points with a handshake, synchronous moves.
extern const Mode kProfilePosition;

}  // namespace vdrive
