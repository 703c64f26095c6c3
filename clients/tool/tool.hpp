// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"

#include <memory>
#include <string>
#include <vector>

namespace vdrive::wire {

class LocalBus;

}  // namespace vdrive::wire

namespace vdrive::tool {

/// The whole tool. Takes SIGINT, SIGTERM, SIGHUP and SIGPIPE for the process.
/// @param arguments without the program's name
/// @param bus of the benches of this process; nothing = the benches of the network
[[nodiscard]] ExitCode run_tool(std::vector<std::string> arguments,
                                const std::shared_ptr<wire::LocalBus>& bus = {});

}  // namespace vdrive::tool
