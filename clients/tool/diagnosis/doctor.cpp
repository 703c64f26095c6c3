// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/doctor.hpp"

#include "diagnosis/bench_checks.hpp"
#include "diagnosis/host_checks.hpp"
#include "diagnosis/ros_checks.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <exception>
#include <future>
#include <iterator>
#include <string>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;

const char* name_of(Severity severity) {
  switch (severity) {
    case Severity::good:
      return "good";
    case Severity::hint:
      return "hint";
    case Severity::problem:
      return "problem";
  }
  return "unknown";
}

void show(const Finding& finding, bool is_json, Terminal& terminal) {
  if (is_json) {
    terminal.print(to_line(finding_json(finding)));
    return;
  }
  const Color color = finding.severity == Severity::good   ? Color::green
                      : finding.severity == Severity::hint ? Color::yellow
                                                           : Color::red;
  std::string word = name_of(finding.severity);
  word.resize(8, ' ');
  terminal.print(colored(terminal, color, word) + " " + finding.subject + ": " + finding.text);
  if (!finding.advice.empty()) terminal.print("         -> " + finding.advice);
}

}  // namespace

Json finding_json(const Finding& finding) {
  Json json{{"severity", name_of(finding.severity)},
            {"subject", finding.subject},
            {"text", finding.text}};
  if (!finding.advice.empty()) json["advice"] = finding.advice;
  for (const client::Figure& figure : finding.figures) {
    json["figures"][std::string(figure.name)] = figure.value;
  }
  return json;
}

Outcome run_doctor(const GlobalOptions& options, Terminal& terminal,
                   const std::function<std::vector<client::BenchInfo>()>& find) {
  std::vector<Finding> findings = check_host(read_host(options.interfaces), options);
  try {
    // Both wait for the network.
    auto ros = std::async(std::launch::async, [&options] {
      return read_ros(options);
    });
    std::ranges::move(check_benches(find(), options), std::back_inserter(findings));
    std::ranges::move(check_ros(ros.get(), options), std::back_inserter(findings));
  } catch (const std::exception& error) {
    findings.push_back(
        {.severity = Severity::problem,
         .subject = "benches",
         .text = error.what(),
         .advice = "solve this problem first; until then the tool cannot search for benches"});
  }
  for (const Finding& finding : findings) show(finding, options.json, terminal);
  const auto problems = std::ranges::count(findings, Severity::problem, &Finding::severity);
  if (problems == 0) return {};
  return Outcome::failed(counted(static_cast<std::uint64_t>(problems), "problem", "problems"));
}

}  // namespace vdrive::tool
