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

/// One line that does something.
struct ScenarioLine {
  std::size_t number = 0;  ///< in the file, from 1
  std::string text;        ///< without comment and outer blanks
  Command command;
  std::optional<Duration> timeout;
  bool is_final = false;  ///< below `finally`: carried out also after a failure
};

struct Scenario {
  std::string file;
  std::vector<ScenarioLine> lines{};
  std::set<std::string> variables{};  ///< that it uses
  std::string mistake{};  ///< why it cannot be carried out, line by line; empty = it can
  std::string source{};   ///< the text of the file, as it was read
};

/// What becomes of a file with a mistake among others.
enum class Mistake : std::uint8_t {
  refuses_all,  ///< nothing is carried out
  is_kept,      ///< Scenario::mistake: the others can be carried out
};

/// Takes a line apart at blanks. A # outside of quotes starts a comment; single and double quotes
/// hold blanks and # together.
/// @throws UsageError for a quote that does not end, and beyond the limits of a line.
[[nodiscard]] std::vector<std::string> split_words(std::string_view line);

/// Reads a whole scenario before anything of it is done.
/// @param commands those that its lines may be
/// @param file its name, for messages
/// @param settings values of variables, from settings_of()
/// @throws UsageError with a line for each mistake, each starting with file:line, also beyond the
///         limits of line and file; and for a file without a command, or with none above finally.
[[nodiscard]] Scenario parse_scenario(CommandTable commands, std::istream& input,
                                      const std::string& file,
                                      const Variables::Values& settings = {});

/// @return how a file is called in messages and reports: - is standard input.
[[nodiscard]] std::string name_of_scenario(const std::string& file);

/// Reads some scenarios. @param names of files; - is standard input
/// @throws UsageError also for a file that cannot be read, and for a variable that no file uses.
///         With Mistake::is_kept for the latter only, and when no file has a mistake.
[[nodiscard]] std::vector<Scenario> load_scenarios(CommandTable commands,
                                                   const std::vector<std::string>& names,
                                                   const Variables::Values& settings,
                                                   Mistake mistake = Mistake::refuses_all);

}  // namespace vdrive::tool
