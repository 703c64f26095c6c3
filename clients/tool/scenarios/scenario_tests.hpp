// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/command.hpp"
#include "scenarios/scenario_files.hpp"
#include "terminal/interrupt.hpp"

#include <cstddef>
#include <string>

namespace vdrive::tool {

/// What is run, and on which benches.
struct ScenarioTestOptions {
  ScenarioFiles scenarios{};
  std::string configuration{};  ///< of the benches; empty = the demo bench
  std::string service{};        ///< empty = found beside the tool or in PATH
  std::size_t jobs = 1;         ///< files at the same time
};

/// Runs each scenario on a bench of its own, several side by side, and writes one report. A bench
/// is a service in lock-step on a domain that no other program uses; it ends with its scenario.
/// @return the exit code of the first file that failed, in the order of the command line.
/// @throws UsageError before anything starts: a mistake in a file, no service, a report that cannot
///         be written.
[[nodiscard]] ExitCode run_scenario_tests(const ScenarioTestOptions& tests, const Program& program,
                                          Interrupt& interrupt);

}  // namespace vdrive::tool
