// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace vdrive::service {

/// What the author of a valid configuration can hardly want.

/// @return the software limits (607Dh) that have no effect because 3535h is not set, a sentence
///         each that names the axis. Cheap enough for each start.
[[nodiscard]] std::vector<std::string> limit_warnings(const Configuration& configuration);

/// @return the loads that the servo loops of their axis cannot hold: lines that name file, line and
///         axis, with numbers. Designs the loops of each axis.
/// @throws ConfigurationError as load_configuration
[[nodiscard]] std::vector<std::string> loop_warnings(const std::filesystem::path& file);

}  // namespace vdrive::service
