// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/command.hpp"
#include "scenarios/private_benches.hpp"
#include "scenarios/scenario_files.hpp"
#include "terminal/interrupt.hpp"

#include <cstddef>

namespace vdrive::tool {

/// What is run, and on which benches.
struct ScenarioTestOptions {
  ScenarioFiles scenarios{};
  PrivateBenches benches{};
  std::size_t jobs = 1;  ///< files at the same time
};

/// Runs each scenario on a bench of its own, several side by side, and writes one report. Each is
/// in a process of its own, `vdrive run --private`: a crash is a failure of one file.
/// @return the exit code of the first file that failed, in the order of the command line.
/// @throws UsageError before anything starts: a mistake in a file, in the configuration or in an
///         option, a report that cannot be written.
[[nodiscard]] ExitCode run_scenario_tests(const ScenarioTestOptions& tests, const Program& program,
                                          Interrupt& interrupt);

}  // namespace vdrive::tool
