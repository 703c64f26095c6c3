// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::ros2 {

/// The program `vdrive-ros2`: reads the command line, serves until SIGINT or SIGTERM.
/// @return its exit code: 0 done, 1 no network, 2 bad command line or configuration
[[nodiscard]] int run_command_line(int argument_count, const char* const* argument_list);

}  // namespace vdrive::ros2
