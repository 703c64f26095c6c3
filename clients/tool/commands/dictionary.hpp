// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "language/command.hpp"
#include "values/value.hpp"

#include <cstdint>
#include <optional>
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

  // Of a data sheet: of one node, with the values that its axis has after power-up.
  std::optional<std::uint64_t> node = {};
  std::optional<std::uint64_t> axis_number = {};  ///< on its bench; none = the node-ID
  std::string preset = {};                        ///< machine; empty = the default axis
  std::string configuration = {};                 ///< file of the bench

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
  ExitCode start(const Program& program) const;
};

/// The object dictionary as lines.
/// @throws UsageError when there is no such axis to read the values from
[[nodiscard]] std::vector<std::string> dictionary_lines(const DictionaryCommand& command);

}  // namespace vdrive::tool
