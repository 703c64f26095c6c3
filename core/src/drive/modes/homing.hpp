// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/mode.hpp"

#include <cstdint>

namespace vdrive {

/// Homing (6061h = 6) by the methods of kHomingMethods.
extern const Mode kHoming;

/// @return whether 6098h takes `value`: 0 (no method) or a supported method.
[[nodiscard]] bool is_homing_method(std::int64_t value);

}  // namespace vdrive
