// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <csignal>
#include <stdexcept>
#include <string>

namespace vdrive::test {

/// kill(2) of one process. @return whether there is such a process.
/// @throws std::invalid_argument for 0 and for a negative number: kill(2) would send the signal to
/// every process of this group, ctest and its caller among them, or to all processes of the user;
/// for 1, which adopts the processes of a parent that has ended
inline bool send_signal(pid_t process, int signal) {
  if (process <= 1) {
    throw std::invalid_argument("signal " + std::to_string(signal) + " to process " +
                                std::to_string(process) + ", which no test has started");
  }
  return ::kill(process, signal) == 0;
}

}  // namespace vdrive::test
