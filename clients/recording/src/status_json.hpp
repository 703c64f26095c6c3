// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace vdrive::recording {

/// Keeps the order in which fields are added.
using Json = nlohmann::ordered_json;

/// @return the members of the status in recordings, in order: first those that correspond to an
///         object, in the order of the dictionary, then the others.
[[nodiscard]] const std::vector<StatusMember>& recorded_members();

/// @return one line; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string to_line(const Json& json);

/// One axis as in the tool's `status` and `watch` and in JSON recordings: positions and velocities
/// in user units, and the actual values also in the unit of the axis.
/// @param unit none = unknown, its fields are null
[[nodiscard]] Json status_json(const client::AxisSnapshot& axis, const std::string& name,
                               const std::optional<client::Unit>& unit);

}  // namespace vdrive::recording
