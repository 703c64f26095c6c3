// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace vdrive::service {

/// A key of a configuration in YAML, but for the numbers of `axes[].model`, which are
/// kModelParameters, and the objects of `axes[].parameters`.
struct ConfigurationKey {
  std::string_view path;  ///< such as "clock.period_us", "axes[].name"
  std::string_view what;  ///< values, unit, limits and meaning
};

/// The keys in the order of the configuration.
[[nodiscard]] std::span<const ConfigurationKey> configuration_keys() noexcept;

/// @return every key with its values and its default: `vdrived --help-config` and the man page
///         vdrived.yaml(5). A key begins its line, its text is indented.
[[nodiscard]] std::string configuration_help();

}  // namespace vdrive::service
