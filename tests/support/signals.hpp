// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <csignal>
#include <stdexcept>
#include <string>

namespace vdrive::test {

/// Calls kill(2) for one process. @return whether the process exists.
/// @throws std::invalid_argument for 0 and negative numbers, for which kill(2) would signal every
///         process of this group, ctest and its caller among them, or all processes of the user;
///         and for 1, which adopts the processes of parents that have ended
inline bool send_signal(pid_t process, int signal) {
  if (process <= 1) {
    throw std::invalid_argument("signal " + std::to_string(signal) + " to process " +
                                std::to_string(process) + ", which no test has started");
  }
  return ::kill(process, signal) == 0;
}

}  // namespace vdrive::test
