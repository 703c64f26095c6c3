// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace vdrive::service {

/// What the author of a valid configuration can hardly want.

/// @return what reading has found in the axes of the file (see axis_warnings), a line each.
[[nodiscard]] std::vector<std::string> start_warnings(const Configuration& configuration);

/// @return the loads that the servo loops of their axis cannot hold: lines that name file, line and
///         axis, with numbers. Designs the loops of each axis.
/// @throws ConfigurationError as load_configuration
[[nodiscard]] std::vector<std::string> loop_warnings(const std::filesystem::path& file);

}  // namespace vdrive::service
