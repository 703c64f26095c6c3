// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/report.hpp"
#include "vdrive/client/axis.hpp"

#include <string>
#include <string_view>

namespace vdrive::tool {

/// What `store` and `restore` say about the stored parameters of an axis. A service without a state
/// directory refuses both.

/// @return such as "bench-1.parameters in the state directory of the service of bench 1".
[[nodiscard]] std::string memory_text(const client::Axis& axis);

/// @param group the object that stores or restores, such as "1010h:01"
/// @return group and file as fields of JSON.
[[nodiscard]] Json memory_json(const client::Axis& axis, std::string_view group);

}  // namespace vdrive::tool
