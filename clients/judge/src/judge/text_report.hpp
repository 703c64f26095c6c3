// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/exceptions.hpp"
#include "judge/judge.hpp"

#include <array>
#include <string>
#include <vector>

namespace vdrive::judge {

/// What a report has besides the verdict.
struct ReportFace {
  std::string source;                ///< such as the name of the log
  AxisName name_of;                  ///< what axes are called
  std::vector<std::string> notes{};  ///< what the source says of itself, a line each
  std::vector<Exception> unused{};   ///< exceptions that cover nothing
};

/// The table around a finding, cell by cell: time, by whom, what, controlword, statusword, mode,
/// target, actual, what the master waited for.
inline constexpr std::array kCycleColumns{"time", "by",     "what",   "controlword", "statusword",
                                          "mode", "target", "actual", "waits for"};
using CycleRow = std::array<std::string, kCycleColumns.size()>;
[[nodiscard]] CycleRow cycle_row(const Line& line);

/// @return whether the finding happened at this line.
[[nodiscard]] bool is_place_of(const Finding& finding, const Line& line);

/// @return such as "3 findings on 2 axes: 1 error, 2 warnings, 0 pieces of advice".
[[nodiscard]] std::string summary_text(const Verdict& verdict);

/// @return such as "handshake-1, mode-1 on node 5, node 6: 6041h is not shown".
[[nodiscard]] std::string unjudged_text(const Unjudged& unjudged, const AxisName& name_of);

/// The verdict as a person reads it: worst first, each finding with the table around it.
/// @return lines, each with its end.
[[nodiscard]] std::string text_report(const Verdict& verdict, const ReportFace& face);

}  // namespace vdrive::judge
