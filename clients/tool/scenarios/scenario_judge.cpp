// SPDX-License-Identifier: Apache-2.0
#include "scenarios/scenario_judge.hpp"

#include "exceptions/exception_file.hpp"
#include "judge/bench_records.hpp"
#include "output/judge_reports.hpp"
#include "replayed/bench_journal.hpp"
#include "vdrive/text.hpp"

#include <fstream>
#include <stdexcept>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

constexpr const char* kCase = "judge";

/// @throws std::runtime_error when the journal cannot be judged
JunitCase judged(const Scenario& scenario, const std::vector<judge::Exception>& exceptions,
                 const std::string& journal, std::optional<judge::Severity> fail_on,
                 ScenarioVerdict& verdict) {
  std::ifstream file(journal, std::ios::binary);
  judge::JournalVerdict result = judge::judge_journal(file);
  judge::ReportLabels labels{.source = scenario.file,
                             .name_of = judge::axes_of_bench(result.bench),
                             .notes = std::move(result.notes)};
  labels.unused = judge::except(result.verdict, exceptions, labels.name_of);
  for (const judge::Exception& unused : labels.unused) {
    verdict.notes.push_back("vdrive: " + escaped(unused.place, kShownOfMessage) +
                            ": the judge found nothing that this exception covers");
  }
  JunitCase test{.name = kCase};
  const std::string text = judge::text_report(result.verdict, labels);
  if (!judge::fails(result.verdict, fail_on)) {
    test.output = result.verdict.findings.empty() ? std::string() : text;
    return test;
  }
  test.failure = judge::summary_text(result.verdict);
  test.type = kCase;
  test.text = text;
  verdict.messages.push_back("vdrive: judge: " + text);
  return test;
}

}  // namespace

void judge_scenario(const Scenario& scenario, const std::string& journal,
                    std::optional<judge::Severity> fail_on, ScenarioVerdict& verdict) {
  const auto fails = [&verdict](ExitCode code) {
    if (verdict.code == 0) verdict.code = static_cast<int>(code);
  };
  JunitCase test{.name = kCase};
  try {
    const auto exceptions = judge::read_exception_comments(scenario.source, scenario.file);
    test = judged(scenario, exceptions, journal, fail_on, verdict);
    if (test.failure) fails(ExitCode::failed);
  } catch (const std::runtime_error& error) {
    test.error = error.what();
    verdict.messages.push_back("vdrive: " + escaped(scenario.file, kShownOfMessage) +
                               " cannot be judged: " + error.what());
    fails(ExitCode::unreadable);
  }
  verdict.suite.cases.push_back(std::move(test));
}

}  // namespace vdrive::tool
