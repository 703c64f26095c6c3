// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"

#include <string>
#include <vector>

namespace vdrive::tool {

/// The whole tool. Takes SIGINT, SIGTERM and SIGPIPE for the process.
/// @param arguments without the program's name
[[nodiscard]] ExitCode run_tool(std::vector<std::string> arguments);

}  // namespace vdrive::tool
