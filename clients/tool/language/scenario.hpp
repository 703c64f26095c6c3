// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "language/variables.hpp"

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// A line with a command.
struct ScenarioLine {
  std::size_t number = 0;  ///< in the file, from 1
  std::string text;        ///< without comment, and trimmed
  Command command;
  std::optional<Duration> timeout;
  bool is_final = false;  ///< below `finally`: executed even after a failure
};

struct Scenario {
  std::string file;
  std::vector<ScenarioLine> lines{};
  std::set<std::string> variables{};  ///< variables in use
  std::string mistake{};  ///< reason why it cannot be executed, line by line; empty = valid
  std::string source{};   ///< the text of the file, as it was read
};

/// How to treat a file with a mistake among several files.
enum class Mistake : std::uint8_t {
  refuses_all,  ///< nothing is executed
  is_kept,      ///< stored in Scenario::mistake: the other files can be executed
};

/// Splits a line at blanks. A # outside of quotes starts a comment; single and double quotes keep
/// blanks and # in a word.
/// @throws UsageError for an unclosed quote, and for a line beyond the limits.
[[nodiscard]] std::vector<std::string> split_words(std::string_view line);

/// Reads a complete scenario before any of it is executed.
/// @param commands those allowed in its lines
/// @param file its name, for messages
/// @param settings values of variables, from settings_of()
/// @throws UsageError with one line per mistake, starting with file:line; also for a line or file
///         beyond the limits, and for a file without a command, or without one above finally.
[[nodiscard]] Scenario parse_scenario(CommandTable commands, std::istream& input,
                                      const std::string& file,
                                      const Variables::Values& settings = {});

/// @return the name of a file in messages and reports: - is standard input.
[[nodiscard]] std::string name_of_scenario(const std::string& file);

/// Reads several scenarios. @param names of files; - is standard input
/// @throws UsageError also for a file that cannot be read, and for a variable that no file uses.
///         With Mistake::is_kept only for such a variable, and only if no file has a mistake.
[[nodiscard]] std::vector<Scenario> load_scenarios(CommandTable commands,
                                                   const std::vector<std::string>& names,
                                                   const Variables::Values& settings,
                                                   Mistake mistake = Mistake::refuses_all);

}  // namespace vdrive::tool
