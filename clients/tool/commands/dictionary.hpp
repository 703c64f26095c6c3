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
  eds,        ///< electronic data sheet of a CANopen node (CiA 306)
  node_json,  ///< of a CANopen node, including its communication objects
};
enum class Language : std::uint8_t { en, zh };

struct DictionaryCommand {
  TableFormat format = TableFormat::table;
  Language language = Language::en;
  std::vector<ObjectName> objects = {};  ///< rows of these objects; none = all

  // Data sheet for this node, with the values that its axis has after power-up.
  std::optional<std::uint64_t> node = {};
  std::optional<std::uint64_t> axis_number = {};  ///< number on its bench; none = the node-ID
  std::string preset = {};                        ///< machine preset; empty = the default axis
  std::string configuration = {};                 ///< file of the bench

  void declare(Arguments& arguments);
  client::Outcome run(CommandContext& context) const;
  ExitCode start(const Program& program) const;
};

/// The object dictionary as lines.
/// @throws UsageError if the axis to read values from does not exist
[[nodiscard]] std::vector<std::string> dictionary_lines(const DictionaryCommand& command);

}  // namespace vdrive::tool
