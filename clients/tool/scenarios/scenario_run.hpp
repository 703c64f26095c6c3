// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/scenario.hpp"
#include "output/junit.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/session.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace vdrive::tool {

/// How a scenario is run and shown.
struct RunOptions {
  bool is_json = false;
  bool is_live = false;     ///< show the axes while time passes, also when not on a terminal
  bool is_private = false;  ///< the bench ends with this program, and no other reaches it
  std::optional<Duration> timeout;
};

/// Runs scenarios one after the other, each until its first failure and then its final lines, and
/// writes the report. A failure does not keep the next file from running, an interrupt does.
/// @return not_found before anything is done when an axis is not there; else the failure with file
///         and line, or, of several files, how many passed: then the failures are on standard
///         error.
client::Outcome run_scenarios(const std::vector<Scenario>& scenarios, const RunOptions& options,
                              JunitReport& junit, client::Session& session, Terminal& terminal);

/// @return the session of the next file; that of the file before has ended.
using NextSession = std::function<client::Session&()>;

/// The same, with a session for each file. All files are checked with that of the first: their
/// benches are equal.
client::Outcome run_scenarios_apart(const std::vector<Scenario>& scenarios,
                                    const RunOptions& options, JunitReport& junit,
                                    const NextSession& next, Terminal& terminal);

}  // namespace vdrive::tool
