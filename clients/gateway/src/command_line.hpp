// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::gateway {

/// The program `vdrive-gateway`: reads the command line, serves until SIGINT or SIGTERM.
/// @return its exit code: 0 done, 1 no network or no port, 2 bad command line
[[nodiscard]] int run_command_line(int argument_count, const char* const* argument_list);

}  // namespace vdrive::gateway
