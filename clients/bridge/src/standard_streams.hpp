// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <unistd.h>

namespace vdrive::bridge {

/// Opens each closed standard stream; call this first in a program. Standard input is then at its
/// end, and writing to the others fails. Otherwise a socket or a file would get the number of a
/// closed stream and be read or written as if it were that stream.
inline void open_standard_streams() noexcept {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    // NOLINTNEXTLINE(*-vararg): the only interface there is
    if (fcntl(stream, F_GETFD) >= 0) continue;
    // open() takes the lowest free number, this one. Read-only, because a write must fail.
    // NOLINTNEXTLINE(*-vararg): the only interface there is
    static_cast<void>(open("/dev/null", O_RDONLY));
  }
}

}  // namespace vdrive::bridge
