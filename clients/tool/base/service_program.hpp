// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdrive::tool {

/// @param chosen by the user; empty = vdrived beside this program, else the one in PATH
/// @throws UsageError when there is none.
[[nodiscard]] std::string find_service(const std::string& chosen);

}  // namespace vdrive::tool
