// SPDX-License-Identifier: Apache-2.0
#include "standard_streams.hpp"

#include <fcntl.h>
#include <unistd.h>

namespace vdrive::bridge {

void open_standard_streams() noexcept {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    // NOLINTNEXTLINE(*-vararg): the only interface there is
    if (fcntl(stream, F_GETFD) >= 0) continue;
    // The lowest number that is free is this one. For reading only: a write has to fail.
    // NOLINTNEXTLINE(*-vararg): the only interface there is
    static_cast<void>(open("/dev/null", O_RDONLY));
  }
}

}  // namespace vdrive::bridge
