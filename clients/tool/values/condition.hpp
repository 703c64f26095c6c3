// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// Conditions of an axis that a command can wait for by name: power states and bits of the
/// statusword, such as `operation_enabled`, `target_reached` or `homing_attained`.

/// @return all names, states first.
[[nodiscard]] const std::vector<std::string>& condition_names();

/// @return " (did you mean 'x'?)" for a name that does not exist, with the nearest name, or with
///         all that contain it as a word ("enabled" is short for operation_enabled); or nothing.
[[nodiscard]] std::string condition_suggestion(std::string_view name);

/// @return whether the axis is in the state `name`, or has that bit set.
[[nodiscard]] bool shows(const client::AxisSnapshot& axis, std::string_view name);

}  // namespace vdrive::tool
