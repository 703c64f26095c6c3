// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings/yaml_reader.hpp"
#include "vdrive/unit.hpp"

#include <yaml-cpp/yaml.h>

namespace vdrive::settings {

/// @return the unit that `axes[].unit` describes; what it does not mention has its default.
/// @throws ConfigurationError when the kind is missing, a key belongs to the other kind, or a value
///         is outside its limits.
[[nodiscard]] Unit read_unit(const YamlValue& value);

/// Writes the map that `read_unit` reads.
void write_unit(YAML::Emitter& out, const Unit& unit);

}  // namespace vdrive::settings
