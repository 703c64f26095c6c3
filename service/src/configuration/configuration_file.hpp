// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"

#include <filesystem>
#include <string>

namespace vdrive::service {

/// Reads a configuration in YAML (docs/guides/configuration.md). What the text does not mention
/// keeps its default.
/// @param file_name as it is named in error messages
/// @throws ConfigurationError when the text is not YAML, a key is unknown or appears twice, a value
///         is of another type or outside its limits, or the bank refuses an axis.
[[nodiscard]] Configuration parse_configuration(const std::string& text,
                                                const std::string& file_name);

/// @throws ConfigurationError as above, and when the file cannot be read.
[[nodiscard]] Configuration load_configuration(const std::filesystem::path& file);

/// @return the configuration as YAML that `parse_configuration` reads back to the same.
[[nodiscard]] std::string to_yaml(const Configuration& configuration);

}  // namespace vdrive::service
