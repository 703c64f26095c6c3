// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "command.hpp"

#include <cstddef>
#include <iosfwd>
#include <optional>
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
};

struct Scenario {
  std::string file;
  std::vector<ScenarioLine> lines;
};

/// Takes a line apart at blanks. A # outside of quotes starts a comment; single and double quotes
/// hold blanks and # together.
/// @throws UsageError for a quote that does not end.
[[nodiscard]] std::vector<std::string> split_words(std::string_view line);

/// Reads a whole scenario before anything of it is done.
/// @param file its name, for messages
/// @throws UsageError starting with file:line.
[[nodiscard]] Scenario parse_scenario(std::istream& input, const std::string& file);

}  // namespace vdrive::tool
