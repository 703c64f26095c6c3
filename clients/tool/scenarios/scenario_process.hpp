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
/// @return the command line of the process that carries out a scenario on a bench of its own.
[[nodiscard]] std::vector<std::string> command_of_process(const std::vector<std::string>& words,
                                                          const Scenario& scenario,
                                                          const ScenarioFiles& scenarios,
                                                          const PrivateBenches& benches,
                                                          const GlobalOptions& options);

/// What the process of one file tells the one that has started it: a JSON object a line.
class FileResults {
 public:
  FileResults();

  /// The result of a line, as --json has it.
  void put(const Json& result);

  /// The last words. @param failure of the file; empty = none
  void end(const std::string& failure, const Terminal& terminal);

 private:
  process::Descriptor file_;
};

/// How such a process has ended.
struct FileEnd {
  /// What became of standard output.
  enum class Stream : std::uint8_t { open, closed_by_reader, failed };

  std::string failure{};
  Stream output = Stream::open;
};

/// @param results what FileResults has written
/// @return nothing where the process has ended before its end, such as by a crash.
[[nodiscard]] std::optional<FileEnd> end_of_file(const std::string& results);

}  // namespace vdrive::tool
