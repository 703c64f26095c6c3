// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace vdrive::service {

/// What the author of a valid configuration can hardly want.

/// @return a sentence each that names the axis: software limits (607Dh) that have no effect because
///         3535h is not set, a unit that contradicts the 4096 user units of a revolution, a 607Fh
///         above what 6080h permits. Cheap enough for each start.
[[nodiscard]] std::vector<std::string> start_warnings(const Configuration& configuration);

/// @return the loads that the servo loops of their axis cannot hold: lines that name file, line and
///         axis, with numbers. Designs the loops of each axis.
/// @throws ConfigurationError as load_configuration
[[nodiscard]] std::vector<std::string> loop_warnings(const std::filesystem::path& file);

}  // namespace vdrive::service
