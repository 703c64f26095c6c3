// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "values/value.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::tool {

enum class TableFormat : std::uint8_t {
  table,
  json,
  csv,
  eds,        ///< of a CANopen node: its electronic data sheet (CiA 306)
  node_json,  ///< of a CANopen node: with its communication objects
};
enum class Language : std::uint8_t { en, zh };

struct DictionaryCommand {
  TableFormat format = TableFormat::table;
  Language language = Language::en;
  std::vector<ObjectName> objects = {};  ///< rows of these; none = all

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
  ExitCode start(const Program& program) const;
};

/// The object dictionary as lines.
[[nodiscard]] std::vector<std::string> dictionary_lines(const DictionaryCommand& command);

}  // namespace vdrive::tool
