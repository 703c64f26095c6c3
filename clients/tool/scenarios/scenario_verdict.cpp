// SPDX-License-Identifier: Apache-2.0
#include "scenarios/scenario_verdict.hpp"

#include "output/report.hpp"

#include <chrono>
#include <cstddef>
#include <map>
#include <sstream>
#include <utility>

namespace vdrive::tool {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

JunitCase skipped_case(const std::string& name) {
  JunitCase test;
  test.name = name;
  test.is_skipped = true;
  return test;
}

/// What `vdrive run --json` has written about each line.
std::map<std::size_t, JunitCase> cases_of(const std::string& output) {
  std::map<std::size_t, JunitCase> cases;
  for (const std::string& text : lines_of(output)) {
    const Json json = Json::parse(text, nullptr, false);
    // What a command of the scenario reads is no verdict.
    if (!json.is_object() || !json.contains("line") || !json.contains("outcome")) continue;
    JunitCase test;
    test.duration = std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double>(json.value("seconds", 0.0)));
    if (json["outcome"] != "ok") test.failure = json.value("message", "");
    cases.emplace(json["line"].get<std::size_t>(), std::move(test));
  }
  return cases;
}

}  // namespace

ScenarioVerdict not_started(const Scenario& scenario) {
  ScenarioVerdict verdict;
  verdict.suite = {scenario.file, {skipped_case("start")}};
  return verdict;
}

ScenarioVerdict failed_to_start(const Scenario& scenario, int code, const std::string& message) {
  JunitCase error;
  error.name = "start";
  error.error = message;
  return {.code = code, .messages = {message}, .suite = {scenario.file, {std::move(error)}}};
}

ScenarioVerdict verdict_of(const Scenario& scenario, const EndedRun& run) {
  const int code = run.code >= 0 ? run.code : static_cast<int>(ExitCode::failed);
  std::vector<std::string> messages = lines_of(run.errors);
  if (run.code < 0) messages.push_back("ended by signal " + std::to_string(-run.code));
  auto cases = cases_of(run.output);
  if (code != 0 && cases.empty()) {
    ScenarioVerdict verdict =
        failed_to_start(scenario, code, messages.empty() ? "interrupted" : messages.back());
    verdict.messages = std::move(messages);
    return verdict;
  }
  ScenarioVerdict verdict{
      .code = code, .messages = std::move(messages), .suite = {scenario.file, {}}};
  for (const ScenarioLine& line : scenario.lines) {
    const std::string name = "line " + std::to_string(line.number) + ": " + line.text;
    const auto found = cases.find(line.number);
    JunitCase& test = verdict.suite.cases.emplace_back(
        found == cases.end() ? skipped_case(name) : std::move(found->second));
    test.name = name;
  }
  return verdict;
}

}  // namespace vdrive::tool
