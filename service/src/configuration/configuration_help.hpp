// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings/rows.hpp"

#include <string>
#include <vector>

namespace vdrive::service {

using settings::ConfigurationKey;

/// The keys in the order of the configuration.
[[nodiscard]] std::vector<ConfigurationKey> configuration_keys();

/// @return every key with its values and its default: `vdrived --help-config` and the man page
///         vdrived.yaml(5). A key begins its line, its text is indented.
[[nodiscard]] std::string configuration_help();

}  // namespace vdrive::service
