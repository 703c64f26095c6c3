// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/grammar.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/terminal.hpp"

namespace vdrive::tool {

/// Runs each scenario on a bench of its own, several side by side, and writes one report. A bench
/// is a service in lock-step on a domain that no other program uses; it ends with its scenario.
/// @return the exit code of the first file that failed, in the order of the command line.
/// @throws UsageError before anything starts: a mistake in a file, no service, a report that cannot
///         be written.
[[nodiscard]] ExitCode run_scenario_tests(const TestCommand& command, const GlobalOptions& options,
                                          Interrupt& interrupt, Terminal& terminal);

}  // namespace vdrive::tool
