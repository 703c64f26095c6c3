// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/command.hpp"
#include "language/global_options.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/session.hpp"

#include <string>

namespace vdrive::tool {

/// @return the options of a session in the network that the options name.
[[nodiscard]] client::SessionOptions session_options(const GlobalOptions& options);

/// Prints on standard error what went wrong. @return the exit code.
ExitCode finish(const client::Outcome& outcome, const Interrupt& interrupt, bool is_json,
                Terminal& terminal);

/// What a second signal leaves behind on the terminal: nothing.
void leave_screen_before_exit(Interrupt& interrupt, Terminal& terminal);

/// Prints a mistake in the command line, which has no command yet. @return ExitCode::usage
ExitCode report_usage(const std::string& message, bool is_json, Terminal& terminal);

/// Does something that a signal interrupts once `work` has armed that.
/// @param work takes the interrupt, @return an outcome
template <typename Work>
ExitCode run_interruptible(const Program& program, const Work& work) {
  Interrupt interrupt;
  leave_screen_before_exit(interrupt, program.terminal);
  const client::Outcome outcome = work(interrupt);
  return finish(outcome, interrupt, program.options.json, program.terminal);
}

/// Opens a session, which a signal interrupts, and does something with it.
/// @param work takes the session, @return an outcome
template <typename Work>
ExitCode run_connected(const Program& program, const GlobalOptions& options, const Work& work) {
  return run_interruptible(program, [&](Interrupt& interrupt) {
    client::Session session(session_options(options));
    interrupt.arm([&session] {
      session.interrupt();
    });
    client::Outcome outcome = work(session);
    interrupt.disarm();
    return outcome;
  });
}

}  // namespace vdrive::tool
