// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/judge.hpp"
#include "judge/text_report.hpp"
#include "output/junit.hpp"
#include "output/record.hpp"

#include <string>
#include <vector>

namespace vdrive::tool {

/// A verdict of the judge in machine-readable forms. Each contains every finding once, worst first.

/// @return one object for each finding, and a final one with the overall result.
[[nodiscard]] std::vector<Json> judge_json(const judge::Verdict& verdict,
                                           const judge::ReportLabels& labels);

/// @return one object for each rule.
[[nodiscard]] std::vector<Json> rules_json();

/// @param fail_on findings of this severity and above are failures; the others appear in the output
///        of a passed case
/// @return one suite with a case for each rule; a rule that could not be judged on any axis is
///         skipped.
[[nodiscard]] JunitSuite judge_junit(const judge::Verdict& verdict,
                                     const judge::ReportLabels& labels, judge::Severity fail_on);

/// @return the log of one run in SARIF 2.1.0, whose locations are lines of the log if it has lines.
///         Findings covered by an exception are suppressed results.
[[nodiscard]] std::string judge_sarif(const judge::Verdict& verdict,
                                      const judge::ReportLabels& labels);

/// @return a self-contained page of HTML, with a picture of the ticks around each finding.
[[nodiscard]] std::string judge_html(const judge::Verdict& verdict,
                                     const judge::ReportLabels& labels);

}  // namespace vdrive::tool
