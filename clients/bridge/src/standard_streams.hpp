// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <unistd.h>

namespace vdrive::bridge {

/// Opens each closed standard stream, first thing in a program: else a socket or a file gets its
/// number, and is read or written to as if it were the stream. Standard input is then at its end;
/// what is written to the others fails.
inline void open_standard_streams() noexcept {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    // NOLINTNEXTLINE(*-vararg): the only interface there is
    if (fcntl(stream, F_GETFD) >= 0) continue;
    // The lowest number that is free is this one. For reading only: a write has to fail.
    // NOLINTNEXTLINE(*-vararg): the only interface there is
    static_cast<void>(open("/dev/null", O_RDONLY));
  }
}

}  // namespace vdrive::bridge
