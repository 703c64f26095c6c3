// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "settings/yaml_reader.hpp"

#include <map>
#include <string>
#include <vector>

namespace vdrive::service {

/// The values of an axis in its file, by key, such as "unit".
using AxisEntries = std::map<std::string, settings::YamlValue>;

/// @param axis the axis that `entries` describe, with number, name and the values that follow from
///        its mechanics
/// @return warnings about settings that are valid but probably not intended, one line each with
///         file, line, key and axis: software limits (607Dh) that have no effect because 3535h is
///         not set, or that have no unit although `mechanics` is used; a unit that contradicts the
///         4096 user units of a revolution; a 607Fh above what 6080h permits, and a 6081h above
///         both.
[[nodiscard]] std::vector<std::string> axis_warnings(const NamedAxis& axis,
                                                     const AxisEntries& entries);

}  // namespace vdrive::service
