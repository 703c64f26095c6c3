// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/scenario.hpp"
#include "output/junit.hpp"
#include "output/report.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/session.hpp"

#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

class FileResults;

/// How scenarios are executed and shown.
struct RunOptions {
  bool is_json = false;
  bool is_live = false;     ///< show the axes while time passes, even if not on a terminal
  bool is_private = false;  ///< the bench ends with this program, and no other program reaches it
  std::optional<Duration> timeout;
  FileResults* results = nullptr;  ///< receives the result of each line; may be nullptr
};

/// Executes scenarios one after the other, each up to its first failure and then its final lines,
/// and writes the report. A failure does not prevent the next file from running; an interrupt does.
/// @return not_found before anything is executed if an axis is missing; otherwise the failure with
///         file and line or, for several files, the number that passed, in which case the failures
///         are on standard error.
client::Outcome run_scenarios(const std::vector<Scenario>& scenarios, const RunOptions& options,
                              JunitReport& junit, client::Session& session, Terminal& terminal);

/// Checks the axes of all scenarios as run_scenarios() does; if an axis is missing, writes the
/// report. Executes nothing.
client::Outcome check_scenarios(const std::vector<Scenario>& scenarios, const RunOptions& options,
                                JunitReport& junit, client::Session& session, Terminal& terminal);

/// As run_scenarios(), but each scenario in its own process: a crash fails only one file. An
/// interrupt is passed on to the running process.
/// @param processes command line of each scenario
client::Outcome run_scenarios_apart(const std::vector<Scenario>& scenarios,
                                    const RunOptions& options, JunitReport& junit,
                                    const std::vector<std::vector<std::string>>& processes,
                                    Interrupt& interrupt, Terminal& terminal);

}  // namespace vdrive::tool
