// SPDX-License-Identifier: Apache-2.0
#include "limit_warnings.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;

/// @return the value that the configuration gives to an object, the last one if there are several.
std::optional<std::int64_t> given(const AxisConfiguration& axis, ObjectRow row) {
  const ObjectAddress address = describe(row).address;
  const auto found = std::find_if(axis.parameters.rbegin(), axis.parameters.rend(),
                                  [address](const InitialValue& parameter) {
                                    return parameter.address == address;
                                  });
  return found == axis.parameters.rend() ? std::nullopt : std::optional(found->value);
}

void warn_of_limits_without_effect(const NamedAxis& axis, std::vector<std::string>& warnings) {
  if (given(axis.configuration, "app_position_limit_switch"_object).value_or(0) != 0) return;
  for (const ObjectRow row :
       std::array{"user_position_lower_limit"_object, "user_position_upper_limit"_object}) {
    const auto limit = given(axis.configuration, row);
    if (!limit) continue;
    warnings.push_back("axis " + std::to_string(axis.number) + " " + escaped(axis.name) + ": " +
                       std::string(describe(row).variable_name) + " = " + std::to_string(*limit) +
                       " has no effect: app_position_limit_switch (3535h) is 0");
  }
}

}  // namespace

std::vector<std::string> limit_warnings(const Configuration& configuration) {
  std::vector<std::string> warnings;
  for (const NamedAxis& axis : configuration.axes) warn_of_limits_without_effect(axis, warnings);
  return warnings;
}

}  // namespace vdrive::service
