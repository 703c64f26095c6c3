// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// What an axis can be waited for by a name: its power state and the bits of its statusword, such
/// as `operation_enabled`, `target_reached` or `homing_attained`.

/// @return all names, states first.
[[nodiscard]] const std::vector<std::string>& condition_names();

/// @return " (did you mean 'x'?)" with the name nearest to one that does not exist, or with those
///         that have it among their words: "enabled" is short for operation_enabled; or nothing.
[[nodiscard]] std::string condition_suggestion(std::string_view name);

/// @return whether the axis is in the state, or shows the bit, that `name` is.
[[nodiscard]] bool shows(const client::AxisSnapshot& axis, std::string_view name);

}  // namespace vdrive::tool
