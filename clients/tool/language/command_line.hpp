// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/bench_names.hpp"
#include "language/command.hpp"
#include "language/global_options.hpp"

#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

/// Parses the words of a line as one of the commands of a table.

/// The request of a command line: either a command or a text (help, version).
struct Invocation {
  GlobalOptions options;
  std::optional<Command> command;
  std::string text;
};

/// @param arguments without the program's name
/// @throws UsageError that names the mistake and how to get help.
[[nodiscard]] Invocation parse_command_line(CommandTable commands,
                                            std::vector<std::string> arguments);

/// Parses one line of a shell: the commands that work in its session, with --json and --timeout;
/// `help`, and `help COMMAND`.
/// @throws UsageError
[[nodiscard]] Invocation parse_shell_command(CommandTable commands, std::vector<std::string> words);

/// One line of a scenario: one of the commands it may have, or `refused`.
struct ScenarioCommand {
  Command command;
  std::optional<Duration> timeout;
};

/// @throws UsageError also for words that make no sense in a scenario.
[[nodiscard]] ScenarioCommand parse_scenario_command(CommandTable commands,
                                                     std::vector<std::string> words);

/// @param words of a command line without the program; the last one is completed
/// @return the words that can replace it.
[[nodiscard]] std::vector<std::string> complete_words(CommandTable commands,
                                                      const std::vector<std::string>& words,
                                                      const BenchNames& names);

/// @return the same for a line of a shell, up to the cursor.
[[nodiscard]] std::vector<std::string> complete_line(CommandTable commands, const std::string& line,
                                                     const BenchNames& names);

}  // namespace vdrive::tool
