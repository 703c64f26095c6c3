// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "child_process.hpp"
#include "language/command.hpp"
#include "language/scenario.hpp"
#include "output/report.hpp"
#include "scenarios/private_benches.hpp"
#include "scenarios/scenario_files.hpp"
#include "terminal/terminal.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// @param words such as `run --private --json`
/// @return the command line of a process that executes a scenario on a private bench.
[[nodiscard]] std::vector<std::string> command_of_process(const std::vector<std::string>& words,
                                                          const Scenario& scenario,
                                                          const ScenarioFiles& scenarios,
                                                          const PrivateBenches& benches,
                                                          const GlobalOptions& options);

/// The results that the process of one file passes to the one that started it: one JSON object per
/// line.
class FileResults {
 public:
  FileResults();

  /// Writes the result of a line, as in --json.
  void put(const Json& result);

  /// Writes the end. @param failure of the file; empty = none
  void end(const std::string& failure, const Terminal& terminal);

 private:
  process::Descriptor file_;
};

/// How the process of one file has ended.
struct FileEnd {
  /// The state of standard output.
  enum class Stream : std::uint8_t { open, closed_by_reader, failed };

  std::string failure{};
  Stream output = Stream::open;
};

/// @param results written by FileResults
/// @return nothing if the process ended prematurely, for example by a crash.
[[nodiscard]] std::optional<FileEnd> end_of_file(const std::string& results);

}  // namespace vdrive::tool
