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

/// @return the options of a session for the network that the user chose.
[[nodiscard]] client::SessionOptions session_options(const GlobalOptions& options);

/// Prints a failure on standard error.
/// @return the exit code.
ExitCode finish(const client::Outcome& outcome, const Interrupt& interrupt, bool is_json,
                Terminal& terminal);

/// Restores the terminal before a second signal ends the process.
void leave_screen_before_exit(Interrupt& interrupt, Terminal& terminal);

/// Prints a mistake in the command line, before a command is known.
/// @return ExitCode::usage
ExitCode report_usage(const std::string& message, bool is_json, Terminal& terminal);

/// Runs `work`. Once `work` has armed the interrupt, a signal interrupts it.
/// @param work takes the interrupt, returns an outcome
template <typename Work>
ExitCode run_interruptible(const Program& program, const Work& work) {
  Interrupt interrupt;
  leave_screen_before_exit(interrupt, program.terminal);
  const client::Outcome outcome = work(interrupt);
  return finish(outcome, interrupt, program.options.json, program.terminal);
}

/// Runs `work` with a new session, which a signal interrupts.
/// @param work takes the session, returns an outcome
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
