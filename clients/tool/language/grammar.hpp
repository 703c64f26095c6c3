// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/bench_names.hpp"
#include "language/command.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Options that stand before or after the command.
struct GlobalOptions {
  std::uint32_t domain = 0;
  std::vector<std::string> interfaces;         ///< own addresses in the networks to use
  std::vector<std::string> peers;              ///< addresses searched beside multicast
  std::vector<std::string> discovery_servers;  ///< such as 10.0.0.9:11811, instead of multicast
  std::string security;                        ///< directory of the closed mode; empty = open
  bool json = false;
  std::optional<Duration> timeout;  ///< wall time to find a service, drive time of motion
};

/// What the command line requests: a command, or a text (help, version) and nothing else.
struct Invocation {
  GlobalOptions options;
  std::optional<Command> command;
  std::string text;
};

/// @param arguments without the program's name
/// @throws UsageError naming what is wrong and how to get help.
[[nodiscard]] Invocation parse_command_line(std::vector<std::string> arguments);

/// One line of a shell: the commands of the command line that work in its session, with --json and
/// --timeout.
/// @throws UsageError
[[nodiscard]] Invocation parse_shell_command(std::vector<std::string> words);

/// @param words of a command line without the program; the last one is completed
/// @return what may stand in its place.
[[nodiscard]] std::vector<std::string> complete_words(const std::vector<std::string>& words,
                                                      const BenchNames& names);

/// @return the same for a line of a shell, up to the cursor.
[[nodiscard]] std::vector<std::string> complete_line(const std::string& line,
                                                     const BenchNames& names);

/// One line of a scenario: the same commands, and `expect`, `wait` and `refused`.
struct ScenarioCommand {
  Command command;
  std::optional<Duration> timeout;
};

/// @throws UsageError also for words that make no sense inside a scenario.
[[nodiscard]] ScenarioCommand parse_scenario_command(std::vector<std::string> words);

}  // namespace vdrive::tool
