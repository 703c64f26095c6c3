// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/scenario.hpp"
#include "output/junit.hpp"

#include <string>
#include <vector>

namespace vdrive::tool {

/// What became of a scenario that a process of its own carries out.
struct ScenarioVerdict {
  int code = static_cast<int>(ExitCode::interrupted);  ///< 0 = passed
  std::vector<std::string> messages;                   ///< of a failure
  JunitSuite suite;
};

/// How the process `vdrive run --json` ended.
struct EndedRun {
  int code = 0;  ///< exit code, or -signal
  std::string output;
  std::string errors;
};

/// @return the verdict before the scenario starts, and if it never does.
[[nodiscard]] ScenarioVerdict not_started(const Scenario& scenario);

/// @return the verdict of a scenario of which no line was carried out.
[[nodiscard]] ScenarioVerdict failed_to_start(const Scenario& scenario, int code,
                                              const std::string& message);

/// @return the verdict with a case for each line; a line without a result was skipped.
[[nodiscard]] ScenarioVerdict verdict_of(const Scenario& scenario, const EndedRun& run);

}  // namespace vdrive::tool
