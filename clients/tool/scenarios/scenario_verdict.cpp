// SPDX-License-Identifier: Apache-2.0
#include "scenarios/scenario_verdict.hpp"

#include "output/report.hpp"
#include "vdrive/bounded_queue.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
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

/// @return the type of an error, which `vdrive test --merge` evaluates.
std::string type_of(int code) {
  switch (static_cast<ExitCode>(code)) {
    case ExitCode::usage:
      return "usage";
    case ExitCode::not_run:
      return JunitCase::kNotRun;
    case ExitCode::interrupted:
      return JunitCase::kInterrupted;
    default:
      return "failed";
  }
}

JunitCase error_case(const std::string& name, int code, const std::string& message) {
  JunitCase error;
  error.name = name;
  error.error = message;
  error.type = type_of(code);
  return error;
}

bool has_failure(const JunitSuite& suite) {
  return std::ranges::any_of(suite.cases, [](const JunitCase& test) {
    return test.failure || test.error;
  });
}

/// @return the last message of a failed process. An interrupted one prints none.
std::string last_of(const std::vector<std::string>& messages) {
  return messages.empty() ? "interrupted" : messages.back();
}

/// The output of a line; of a long output, the last part.
using LineOutput = BoundedQueue<std::string>;

LineOutput no_output() {
  constexpr std::size_t kMostLines = 100;
  return {kMostLines, WhenFull::drops_oldest};
}

std::string text_of(const LineOutput& output) {
  std::string text;
  if (output.dropped() != 0)
    text = "(" + counted(output.dropped(), "line", "lines") + " omitted)\n";
  for (const std::string& line : output.items()) text.append(line).append("\n");
  return text;
}

/// The output of `vdrive run --json` for each line.
using LineResults = std::map<std::size_t, JunitCase>;

/// @return the failure in a result, with all its details.
LineFailure failure_of(const Json& result) {
  return {.message = result.value("message", ""),
          .details = result.value("details", std::vector<std::string>()),
          .advice = result.value("advice", "")};
}

JunitCase case_of(const Scenario& scenario, const ScenarioLine& line, const Json& result) {
  JunitCase test;
  test.duration = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(result.value("seconds", 0.0)));
  if (result["outcome"] == "ok") return test;
  const LineFailure failure = failure_of(result);
  test.failure = failure.message;
  test.type = result.value("type", result.value("outcome", ""));
  test.text = failure_text(scenario, line, failure);
  return test;
}

LineResults results_of(const Scenario& scenario, const std::string& output) {
  LineResults results;
  LineOutput printed = no_output();
  for (const std::string& text : lines_of(output)) {
    const Json json = Json::parse(text, nullptr, false);
    const bool is_result = json.is_object() && json.contains("line") && json.contains("outcome");
    const auto line = std::ranges::find_if(scenario.lines, [&](const ScenarioLine& each) {
      return is_result && each.number == json["line"];
    });
    if (line == scenario.lines.end()) {  // output of a command in the scenario, not a result
      printed.put(text);
      continue;
    }
    JunitCase test = case_of(scenario, *line, json);
    test.output = text_of(std::exchange(printed, no_output()));
    results.emplace(line->number, std::move(test));
  }
  return results;
}

/// @return the exit code of a run. A crash counts as failed. SIGKILL comes from outside, for
///         example from the kernel when memory runs out, and counts as not run.
int code_of(const EndedRun& run) {
  if (run.code >= 0) return run.code;
  return static_cast<int>(run.code == -SIGKILL ? ExitCode::not_run : ExitCode::failed);
}

}  // namespace

std::string failure_text(const Scenario& scenario, const ScenarioLine& line,
                         const LineFailure& failure) {
  std::string text = escaped(scenario.file, kShownOfMessage) + ":" + std::to_string(line.number) +
                     ": " + escaped(line.text, kShownOfMessage) + ": " + failure.message;
  for (const std::string& detail : failure.details) text.append("\n  ").append(detail);
  if (!failure.advice.empty()) text.append("\n  next: ").append(failure.advice);
  return text;
}

Record end_record(const Scenario& scenario, bool passed, std::size_t done,
                  const Terminal& terminal) {
  const std::string word =
      colored(terminal, passed ? Color::green : Color::red, passed ? "passed" : "failed");
  return {{"file", scenario.file, word + "  " + escaped(scenario.file, kShownOfMessage) + ","},
          {"passed", passed},
          {"lines", scenario.lines.size()},
          {"done", done, lines_text(done, scenario.lines.size())}};
}

std::string name_of_line(const ScenarioLine& line) {
  return "line " + std::to_string(line.number) + ": " + line.text;
}

std::string lines_text(std::size_t done, std::size_t all) {
  const std::string text = counted(all, "line", "lines");
  return done == all ? text : std::to_string(done) + " of " + text + " done";
}

ScenarioVerdict not_started(const Scenario& scenario) {
  ScenarioVerdict verdict;
  verdict.suite = {scenario.file, {skipped_case("start")}};
  return verdict;
}

ScenarioVerdict failed_to_start(const Scenario& scenario, int code, const std::string& message) {
  return {.code = code,
          .messages = {message},
          .suite = {scenario.file, {error_case("start", code, message)}}};
}

ScenarioVerdict verdict_of(const Scenario& scenario, const EndedRun& run) {
  int code = code_of(run);
  std::vector<std::string> messages = lines_of(run.errors);
  if (run.code < 0) messages.push_back("ended by signal " + std::to_string(-run.code));
  LineResults results = results_of(scenario, run.output);
  // The process reads the file again: a pipe, or a file changed since, has different lines then.
  if (code == 0 && results.size() != scenario.lines.size()) {
    code = static_cast<int>(ExitCode::failed);
    messages.push_back("vdrive: " + escaped(scenario.file, kShownOfMessage) +
                       ": has changed since it was first read: " +
                       lines_text(results.size(), scenario.lines.size()) +
                       "; a pipe can be read only once: use vdrive run --private");
  }
  if (code != 0 && results.empty()) {
    ScenarioVerdict verdict = failed_to_start(scenario, code, last_of(messages));
    verdict.messages = std::move(messages);
    return verdict;
  }
  ScenarioVerdict verdict{.code = code,
                          .messages = std::move(messages),
                          .suite = {scenario.file, {}},
                          .done = results.size()};
  for (const ScenarioLine& line : scenario.lines) {
    const std::string name = name_of_line(line);
    const auto found = results.find(line.number);
    JunitCase& test = verdict.suite.cases.emplace_back(
        found == results.end() ? skipped_case(name) : std::move(found->second));
    test.name = name;
    test.line = line.number;
    if (test.failure && code == static_cast<int>(ExitCode::interrupted)) {
      test.type = JunitCase::kInterrupted;
    }
  }
  if (code != 0 && (run.code < 0 || !has_failure(verdict.suite))) {
    verdict.suite.cases.push_back(error_case("end", code, last_of(verdict.messages)));
  }
  return verdict;
}

}  // namespace vdrive::tool
