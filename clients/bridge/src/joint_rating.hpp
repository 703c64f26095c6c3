// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis.hpp"
#include "vdrive/unit.hpp"

#include <optional>

namespace vdrive::bridge {

/// Reads the torque rating of an axis, and waits for it.
/// @return its effort_per_mille(); none when it cannot be read
[[nodiscard]] std::optional<double> read_effort_per_mille(const client::Axis& axis,
                                                          const Unit& unit);

}  // namespace vdrive::bridge
