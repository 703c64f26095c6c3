// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "executor.hpp"
#include "junit.hpp"
#include "scenario.hpp"

#include <optional>

namespace vdrive::tool {

/// How a scenario is run and shown.
struct RunOptions {
  bool is_json = false;
  bool is_live = false;  ///< show the axes while time passes, also when not on a terminal
  std::optional<Duration> timeout;
};

/// Runs the lines until the first failure, and writes the report.
/// @return not_found before anything is done when an axis is not there; else the failure, with
///         file and line.
client::Outcome run_scenario(const Scenario& scenario, const RunOptions& options,
                             JunitReport& junit, client::Session& session, Terminal& terminal);

}  // namespace vdrive::tool
