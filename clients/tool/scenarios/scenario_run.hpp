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

/// How a scenario is run and shown.
struct RunOptions {
  bool is_json = false;
  bool is_live = false;     ///< show the axes while time passes, also when not on a terminal
  bool is_private = false;  ///< the bench ends with this program, and no other reaches it
  std::optional<Duration> timeout;
  FileResults* results = nullptr;  ///< gets the result of each line; none = nobody asks
};

/// Runs scenarios one after the other, each until its first failure and then its final lines, and
/// writes the report. A failure does not keep the next file from running, an interrupt does.
/// @return not_found before anything is done when an axis is not there; else the failure with file
///         and line, or, of several files, how many passed: then the failures are on standard
///         error.
client::Outcome run_scenarios(const std::vector<Scenario>& scenarios, const RunOptions& options,
                              JunitReport& junit, client::Session& session, Terminal& terminal);

/// Checks the axes of all scenarios as run_scenarios() does, and writes the report if one is not
/// there. Nothing is carried out.
client::Outcome check_scenarios(const std::vector<Scenario>& scenarios, const RunOptions& options,
                                JunitReport& junit, client::Session& session, Terminal& terminal);

/// The same as run_scenarios(), each scenario in a process of its own: a crash is a failure of one
/// file. An interrupt is passed on to the process that runs.
/// @param processes the command line of each
client::Outcome run_scenarios_apart(const std::vector<Scenario>& scenarios,
                                    const RunOptions& options, JunitReport& junit,
                                    const std::vector<std::vector<std::string>>& processes,
                                    Interrupt& interrupt, Terminal& terminal);

}  // namespace vdrive::tool
