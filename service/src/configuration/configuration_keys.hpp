// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "settings/rows.hpp"

#include <map>
#include <span>
#include <string>

namespace vdrive::service {

using settings::YamlValue;

/// The axes of a file, and where they stand, to name the place when the bank refuses one.
struct ParsedAxes {
  std::vector<NamedAxis> axes;
  std::map<std::uint16_t, YamlValue> places;  ///< by axis number
};

/// What a file says, before the axes are tried.
struct ParsedConfiguration {
  Configuration configuration;
  ParsedAxes axes;  ///< empty = those of `configuration`
};

/// The keys of a configuration, and of the sections that they begin: bench, clock, status,
/// watchdog, wire, metrics, network, axes.
[[nodiscard]] std::span<const settings::Row<ParsedConfiguration>> configuration_rows() noexcept;

/// Every key of an element of `axes`.
[[nodiscard]] std::span<const settings::Row<NamedAxis>> axis_rows() noexcept;

/// @throws ConfigurationError when a name does not have 1 to 64 bytes, or has a control character
void check_name(const YamlValue& value, const std::string& name);

}  // namespace vdrive::service
