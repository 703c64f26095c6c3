// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::canopen {

/// The program `vdrive-canopen`: reads the command line and serves until SIGINT or SIGTERM.
/// @return its exit code: 0 done, 1 no network or no port, 2 bad command line or configuration
[[nodiscard]] int run_command_line(int argument_count, const char* const* argument_list);

}  // namespace vdrive::canopen
