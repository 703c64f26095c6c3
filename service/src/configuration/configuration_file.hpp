// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"

#include <filesystem>
#include <string>

namespace vdrive::service {

/// Reads a configuration in YAML (docs/guides/configuration.md). Keys that are absent keep their
/// defaults.
/// @param file_name for error messages
/// @throws ConfigurationError if the text is not YAML, a key is unknown or appears twice, a value
///         has the wrong type or is outside its limits, or the bank refuses an axis
[[nodiscard]] Configuration parse_configuration(const std::string& text,
                                                const std::string& file_name);

/// @throws ConfigurationError as above, and if the file cannot be read
[[nodiscard]] Configuration load_configuration(const std::filesystem::path& file);

/// @return the configuration as YAML, from which `parse_configuration` reads the same
/// configuration.
[[nodiscard]] std::string to_yaml(const Configuration& configuration);

}  // namespace vdrive::service
