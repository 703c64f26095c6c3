// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/command.hpp"
#include "terminal/interrupt.hpp"
#include "vdrive/client/session.hpp"

namespace vdrive::tool {

/// Reads commands from standard input and carries them out in one session, until the end of the
/// input, `exit` or `quit`. A failure does not end it; Ctrl-C ends the command that runs. `help`
/// shows the commands, `help COMMAND` one. SIGTERM, SIGHUP and, without a terminal, Ctrl-C between
/// two commands end it.
/// @return interrupted where a signal has ended it; else of a terminal ok, and without one the exit
///         code of the first command that failed.
[[nodiscard]] ExitCode run_shell(const Program& program, client::Session& session,
                                 Interrupt& interrupt);

}  // namespace vdrive::tool
