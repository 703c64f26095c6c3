// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace vdrive::service {

// Warnings about settings that are valid but probably not intended.

/// @return the warnings found while reading the axes (see axis_warnings), one line each.
[[nodiscard]] std::vector<std::string> start_warnings(const Configuration& configuration);

/// Designs the servo loops of each axis.
/// @return warnings about loads that the loops cannot control, one line each, with file, line, axis
///         and numbers
/// @throws ConfigurationError as load_configuration
[[nodiscard]] std::vector<std::string> loop_warnings(const std::filesystem::path& file);

}  // namespace vdrive::service
