// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdrive::service {

/// The program `vdrived`: reads the command line and runs the service until SIGINT or SIGTERM.
/// @return the exit code: 0 = success, 1 = bad configuration, no network, or a replay that differs,
///         2 = bad command line or journal, 5 = the bench number belongs to another service
[[nodiscard]] int run_command_line(int argument_count, const char* const* arguments);

}  // namespace vdrive::service
