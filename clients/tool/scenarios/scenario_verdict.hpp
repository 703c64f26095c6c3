// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/exit_code.hpp"
#include "language/scenario.hpp"
#include "output/junit.hpp"
#include "output/record.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Why a line of a scenario failed, with help for the user.
struct LineFailure {
  std::string message;
  std::vector<std::string> details;  ///< status of the axes, one line each
  std::string advice;                ///< next step; may be empty
};

/// @return the failure with file and line, followed by the indented details and the next step.
[[nodiscard]] std::string failure_text(const Scenario& scenario, const ScenarioLine& line,
                                       const LineFailure& failure);

/// @return the name of a line in a report, such as "line 2: enable 1.1".
[[nodiscard]] std::string name_of_line(const ScenarioLine& line);

/// @return such as "32 lines", or "11 of 32 lines done" if not all were executed.
[[nodiscard]] std::string lines_text(std::size_t done, std::size_t all);

/// @param done number of executed lines
/// @return the record about the end of a scenario.
[[nodiscard]] Record end_record(const Scenario& scenario, bool passed, std::size_t done,
                                const Terminal& terminal);

/// The result of a scenario that was executed in its own process.
struct ScenarioVerdict {
  int code = static_cast<int>(ExitCode::interrupted);  ///< 0 = passed
  std::vector<std::string> messages;                   ///< of a failure
  std::vector<std::string> notes{};                    ///< even if it passed
  JunitSuite suite;
  std::size_t done = 0;  ///< executed lines, including the failed one
};

/// How the process `vdrive run --json` ended.
struct EndedRun {
  int code = 0;  ///< exit code, or -signal
  std::string output;
  std::string errors;
};

/// @return the verdict before the scenario starts, which remains if it never does.
[[nodiscard]] ScenarioVerdict not_started(const Scenario& scenario);

/// @return the verdict of a scenario of which no line was executed.
[[nodiscard]] ScenarioVerdict failed_to_start(const Scenario& scenario, int code,
                                              const std::string& message);

/// @return the verdict with a case for each line; a line without a result was skipped. An end that
///         no line explains, such as a crash, gets its own case.
[[nodiscard]] ScenarioVerdict verdict_of(const Scenario& scenario, const EndedRun& run);

}  // namespace vdrive::tool
