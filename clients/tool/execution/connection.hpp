// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/command.hpp"
#include "language/global_options.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/session.hpp"

#include <functional>
#include <vector>

namespace vdrive::tool {

/// @return the options of a session in the network that the options name.
[[nodiscard]] client::SessionOptions session_options(const GlobalOptions& options);

/// Prints on standard error what went wrong. @return the exit code.
ExitCode finish(const client::Outcome& outcome, const Interrupt& interrupt, bool is_json,
                Terminal& terminal);

/// Does something that a signal interrupts once `work` has armed that.
ExitCode run_interruptible(const Program& program,
                           const std::function<client::Outcome(Interrupt&)>& work);

/// Opens a session, which a signal interrupts, and does something with it.
ExitCode run_connected(const Program& program, const GlobalOptions& options,
                       const std::function<client::Outcome(client::Session&)>& work);

}  // namespace vdrive::tool
