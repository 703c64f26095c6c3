// SPDX-License-Identifier: Apache-2.0
// The judge of masters, applied to the journal of a bench.
#include "interpreter_lock.hpp"
#include "judge/bench_records.hpp"
#include "judge/exceptions.hpp"
#include "judge/rule.hpp"
#include "judge/text_report.hpp"
#include "python.hpp"
#include "replayed/bench_journal.hpp"
#include "vdrive/text.hpp"

#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::python {
namespace {

/// The result for a journal, obtained without the interpreter lock.
struct Judged {
  judge::JournalVerdict verdict;
  std::string problem;
};

Judged judged(const std::string& path) {
  const Unlocked unlocked;
  std::ifstream file(path, std::ios::binary);
  if (!file) return {.verdict = {}, .problem = "cannot be read"};
  try {
    return {.verdict = judge::judge_journal(file), .problem = {}};
  } catch (const std::runtime_error& error) {
    return {.verdict = {}, .problem = error.what()};
  }
}

/// @return a finding as a record in the form of vdrive/_judge.py.
py::tuple record_of(const judge::Finding& finding, const judge::AxisName& name_of) {
  const judge::RuleRow& row = judge::row_of(finding.rule);
  return py::make_tuple(row.name, judge::to_string(row.severity), name_of(finding.axis),
                        finding.count, finding.first.tick, row.title, finding.happened,
                        row.expected, row.remedy);
}

/// @param off rules that the master breaks on purpose, each with its reason
/// @return the findings, the rules of `off` that were not broken, and a readable report.
py::tuple judge_journal(const std::string& path,
                        const std::vector<std::pair<std::string, std::string>>& off) {
  std::vector<judge::Exception> exceptions;
  for (const auto& [name, reason] : off) {
    const auto rule = judge::find_rule(name);
    if (!rule) throw py::value_error(in_quotes(name) + " is not a rule of the judge");
    exceptions.push_back({.rule = *rule, .axis = {}, .reason = reason, .place = {}});
  }
  Judged result = judged(path);
  if (!result.problem.empty()) {
    throw py::value_error(path + " cannot be judged: " + result.problem);
  }
  judge::Verdict& verdict = result.verdict.verdict;
  judge::ReportLabels labels{.source = path,
                             .name_of = judge::axes_of_bench(result.verdict.bench),
                             .notes = result.verdict.notes};
  labels.unused = judge::except(verdict, exceptions, labels.name_of);
  py::list findings;
  for (const judge::Finding& finding : verdict.findings) {
    findings.append(record_of(finding, labels.name_of));
  }
  py::list unused;
  for (const judge::Exception& exception : labels.unused) {
    unused.append(judge::row_of(exception.rule).name);
  }
  return py::make_tuple(findings, unused, judge::text_report(verdict, labels));
}

}  // namespace

void add_judge(py::module_& module) {
  module.def("judge_journal", &judge_journal);
}

}  // namespace vdrive::python
