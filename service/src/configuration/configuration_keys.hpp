// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "settings/rows.hpp"

#include <map>
#include <span>
#include <string>

namespace vdrive::service {

using settings::YamlValue;

/// The axes of a file, and their places in it, for the message when the bank refuses one.
struct ParsedAxes {
  std::vector<NamedAxis> axes;
  std::map<std::uint16_t, YamlValue> places;  ///< by axis number
};

/// The content of a file, before the bank has tried the axes.
struct ParsedConfiguration {
  Configuration configuration;
  ParsedAxes axes;  ///< empty = use the axes of `configuration`
};

/// @return the top-level keys of a configuration: bench, clock, status, watchdog, wire, black_box,
///         metrics, network, axes, each with the keys of its section.
[[nodiscard]] std::span<const settings::Row<ParsedConfiguration>> configuration_rows() noexcept;

/// @return all keys of an element of `axes`.
[[nodiscard]] std::span<const settings::Row<NamedAxis>> axis_rows() noexcept;

/// @throws ConfigurationError if a name does not have 1 to 64 bytes, or has a control character
void check_name(const YamlValue& value, const std::string& name);

}  // namespace vdrive::service
