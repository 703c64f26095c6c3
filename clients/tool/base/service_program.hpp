// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace vdrive::tool {

/// @param chosen by the user; empty = vdrived next to this program, otherwise from PATH
/// @throws UsageError if there is none.
[[nodiscard]] std::string find_service(const std::string& chosen);

}  // namespace vdrive::tool
