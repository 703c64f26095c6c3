// SPDX-License-Identifier: Apache-2.0
#include "scenarios/scenario_process.hpp"

#include "language/variables.hpp"
#include "private_bench.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <sstream>
#include <string_view>

namespace vdrive::tool {
namespace {

constexpr const char* kFailure = "failure";
constexpr const char* kOutput = "output";

}  // namespace

std::vector<std::string> command_of_process(const std::vector<std::string>& words,
                                            const Scenario& scenario,
                                            const ScenarioFiles& scenarios,
                                            const PrivateBenches& benches,
                                            const GlobalOptions& options) {
  std::vector<std::string> command{process::own_program()};
  command.insert(command.end(), words.begin(), words.end());
  for (std::string& word : benches.arguments()) command.push_back(std::move(word));
  if (options.timeout) {
    const auto timeout = std::chrono::duration_cast<std::chrono::microseconds>(*options.timeout);
    command.insert(command.end(), {"--timeout", std::to_string(timeout.count()) + "us"});
  }
  if (std::ranges::count(options.network_given, "--security") != 0) {
    command.insert(command.end(), {"--security", options.security});
  }
  for (const auto& [name, value] : settings_of(scenarios.settings)) {
    // Only the variables of this file: the process would not know any others.
    if (scenario.variables.contains(name)) {
      command.emplace_back("--set");
      command.emplace_back(name).append("=").append(value);
    }
  }
  command.insert(command.end(), {"--", scenario.file});
  return command;
}

FileResults::FileResults() : file_(process::kChildResults) {
  // The service of a bench must not inherit the descriptor. If this process was started without the
  // descriptor, the call fails, and no results are reported.
  (void)fcntl(file_.get(), F_SETFD, FD_CLOEXEC);  // NOLINT(*-vararg)
}

void FileResults::put(const Json& result) {
  const std::string text = to_line(result) + "\n";
  for (std::size_t written = 0; written < text.size();) {
    const std::string_view rest = std::string_view(text).substr(written);
    const ssize_t count = write(file_.get(), rest.data(), rest.size());
    if (count <= 0) return;
    written += static_cast<std::size_t>(count);
  }
}

void FileResults::end(const std::string& failure, const Terminal& terminal) {
  auto output = FileEnd::Stream::open;
  if (!terminal.is_open()) {
    output = terminal.write_failure() ? FileEnd::Stream::failed : FileEnd::Stream::closed_by_reader;
  }
  put({{kFailure, failure}, {kOutput, output}});
}

std::optional<FileEnd> end_of_file(const std::string& results) {
  std::optional<FileEnd> end;
  std::istringstream lines(results);
  for (std::string line; std::getline(lines, line);) {
    const Json json = Json::parse(line, nullptr, false);
    if (!json.is_object() || !json.contains(kOutput)) continue;
    end = FileEnd{.failure = json.value(kFailure, ""),
                  .output = json.value(kOutput, FileEnd::Stream::open)};
  }
  return end;
}

}  // namespace vdrive::tool
