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

/// Runs the tool. Takes over SIGINT, SIGTERM, SIGHUP and SIGPIPE of the process.
/// @param arguments without the program's name
/// @param bus connects the benches of this process; nothing = use the network
[[nodiscard]] ExitCode run_tool(std::vector<std::string> arguments,
                                const std::shared_ptr<wire::LocalBus>& bus = {});

}  // namespace vdrive::tool
