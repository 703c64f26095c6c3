// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/exceptions.hpp"
#include "judge/judge.hpp"

#include <array>
#include <string>
#include <vector>

namespace vdrive::judge {

/// The parts of a report in addition to the verdict.
struct ReportLabels {
  std::string source;                ///< such as the name of the log
  AxisName name_of;                  ///< display names of the axes
  std::vector<std::string> notes{};  ///< notes of the source about itself, one per line
  std::vector<Exception> unused{};   ///< exceptions that cover nothing
};

/// The columns of the table around a finding: time, author, change, controlword, statusword, mode,
/// target, actual position, and what the master was waiting for.
inline constexpr std::array kCycleColumns{"time", "by",     "what",   "controlword", "statusword",
                                          "mode", "target", "actual", "waits for"};
using CycleRow = std::array<std::string, kCycleColumns.size()>;
[[nodiscard]] CycleRow cycle_row(const Line& line);

/// @return whether this line is where the finding occurred.
[[nodiscard]] bool is_place_of(const Finding& finding, const Line& line);

/// @return such as "3 findings on 2 axes: 1 error, 2 warnings, 0 pieces of advice".
[[nodiscard]] std::string summary_text(const Verdict& verdict);

/// @return such as "handshake-1, mode-1 on node 5, node 6: 6041h is not shown".
[[nodiscard]] std::string unjudged_text(const Unjudged& unjudged, const AxisName& name_of);

/// The verdict for a reader: worst first, each finding with the table around it.
/// @return lines, each with its line end.
[[nodiscard]] std::string text_report(const Verdict& verdict, const ReportLabels& labels);

}  // namespace vdrive::judge
