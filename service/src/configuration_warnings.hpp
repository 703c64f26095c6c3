// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vdrive::service {

/// Examines a configuration that can be used for what its author can hardly want: loads that the
/// servo loops of their axis cannot hold.
/// @return lines that name file, line and axis, with numbers.
/// @throws ConfigurationError as load_configuration
[[nodiscard]] std::vector<std::string> configuration_warnings(const std::filesystem::path& file);

}  // namespace vdrive::service
