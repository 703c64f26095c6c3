// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/report.hpp"
#include "vdrive/client/axis.hpp"

#include <string>

namespace vdrive::tool {

/// What `store` and `restore` say about the stored parameters of an axis. A service without a state
/// directory refuses both.

/// @return such as "91 parameters (1010h:01)".
[[nodiscard]] std::string parameters_text();

/// @return such as "bench-1.parameters in the state directory of the service of bench 1".
[[nodiscard]] std::string memory_text(const client::Axis& axis);

/// @return both as fields of JSON.
[[nodiscard]] Json memory_json(const client::Axis& axis);

}  // namespace vdrive::tool
