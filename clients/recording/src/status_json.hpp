// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis_snapshot.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace vdrive::recording {

/// Keeps the order in which fields are written.
using Json = nlohmann::ordered_json;

/// @return the members of the status that recordings have, in their order: those that show an
///         object as the dictionary has them, then the others.
[[nodiscard]] const std::vector<StatusMember>& recorded_members();

/// @return one line; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string to_line(const Json& json);

/// One axis as the tool's `status`, `watch` and JSON recordings have it: positions and velocities
/// in user units, and the actual ones in the unit of the axis, too.
/// @param unit none = not known, its fields are null
[[nodiscard]] Json status_json(const client::AxisSnapshot& axis, const std::string& name,
                               const std::optional<client::Unit>& unit);

}  // namespace vdrive::recording
