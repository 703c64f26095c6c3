// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "configuration/configuration_rows.hpp"

#include <map>
#include <span>

namespace vdrive::service {

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
[[nodiscard]] std::span<const ConfigurationRow<ParsedConfiguration>> configuration_rows() noexcept;

/// Every key of an element of `axes`.
[[nodiscard]] std::span<const ConfigurationRow<NamedAxis>> axis_rows() noexcept;

/// @return 1 to 64 bytes of UTF-8 without control characters; the name of an axis has no blank and
///         begins with no digit.
/// @throws ConfigurationError when it is no such name
[[nodiscard]] std::string checked_name(const YamlValue& value, bool of_axis);

}  // namespace vdrive::service
