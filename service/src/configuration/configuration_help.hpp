// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings/rows.hpp"

#include <string>
#include <vector>

namespace vdrive::service {

using settings::ConfigurationKey;

/// @return the keys in the order of the configuration.
[[nodiscard]] std::vector<ConfigurationKey> configuration_keys();

/// @return all keys with their values and defaults, for `vdrived --help-config` and the man page
///         vdrived.yaml(5). A key starts in the first column, its text is indented.
[[nodiscard]] std::string configuration_help();

}  // namespace vdrive::service
