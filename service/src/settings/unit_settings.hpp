// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings/rows.hpp"
#include "vdrive/unit.hpp"

#include <string>
#include <vector>

namespace vdrive::settings {

/// Reads the unit in `axes[].unit`; absent keys have their defaults.
/// @throws ConfigurationError if the kind is missing, a key belongs to the other kind, or a value
///         is outside its limits
void read_value(const YamlValue& value, const Any& rule, Unit& unit);

/// Writes the map that `read_value` reads.
void write_value(YAML::Emitter& out, const Any& rule, const Unit& unit);

/// Adds the keys of a unit at `path`.
void describe_unit(const std::string& path, std::vector<ConfigurationKey>& keys);

}  // namespace vdrive::settings
