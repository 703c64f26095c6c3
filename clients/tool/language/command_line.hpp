// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/bench_names.hpp"
#include "language/command.hpp"
#include "language/global_options.hpp"

#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Reads the words of a line as one of the commands of a table.

/// What the command line requests: a command, or a text (help, version) and nothing else.
struct Invocation {
  GlobalOptions options;
  std::optional<Command> command;
  std::string text;
};

/// @param arguments without the program's name
/// @throws UsageError naming what is wrong and how to get help.
[[nodiscard]] Invocation parse_command_line(CommandTable commands,
                                            std::vector<std::string> arguments);

/// One line of a shell: the commands of the command line that work in its session, with --json and
/// --timeout; `help`, and `help COMMAND`.
/// @throws UsageError
[[nodiscard]] Invocation parse_shell_command(CommandTable commands, std::vector<std::string> words);

/// One line of a scenario: the commands that it may have, and `refused`.
struct ScenarioCommand {
  Command command;
  std::optional<Duration> timeout;
};

/// @throws UsageError also for words that make no sense inside a scenario.
[[nodiscard]] ScenarioCommand parse_scenario_command(CommandTable commands,
                                                     std::vector<std::string> words);

/// @param words of a command line without the program; the last one is completed
/// @return what may stand in its place.
[[nodiscard]] std::vector<std::string> complete_words(CommandTable commands,
                                                      const std::vector<std::string>& words,
                                                      const BenchNames& names);

/// @return the same for a line of a shell, up to the cursor.
[[nodiscard]] std::vector<std::string> complete_line(CommandTable commands, const std::string& line,
                                                     const BenchNames& names);

}  // namespace vdrive::tool
