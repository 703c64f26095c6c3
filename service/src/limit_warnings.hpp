// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration.hpp"

#include <string>
#include <vector>

namespace vdrive::service {

/// @return the software limits (607Dh) of a configuration that have no effect because 3535h is not
///         set, a sentence each that names the axis.
[[nodiscard]] std::vector<std::string> limit_warnings(const Configuration& configuration);

}  // namespace vdrive::service
