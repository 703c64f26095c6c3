// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "status_json.hpp"
#include "terminal/terminal.hpp"
#include "vdrive/client/outcome.hpp"
#include "vdrive/client/session_name.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::tool {

using recording::Json;
using recording::to_line;

/// Where and how the commands of a session print their answers.
struct Output {
  Terminal& terminal;
  bool is_json;         ///< one JSON object per line instead of text
  const bool is_quiet;  ///< print only the answers of reading commands
};

/// A field of a record.
struct Field {
  std::string name;    ///< in JSON
  Json value;          ///< in JSON
  std::string text{};  ///< in the line of text, with its unit; empty = only in JSON
};

/// The answer of a command: its fields, in the order in which both JSON and text show them. A
/// phrase about several fields is stored as the text of the last of them.
using Record = std::vector<Field>;

/// @return the fields as an object; the last of equal names counts.
[[nodiscard]] Json record_json(const Record& record);

/// @return the texts of the fields, separated by blanks.
[[nodiscard]] std::string record_text(const Record& record);

/// @return the non-empty texts of the fields, as a row of a table.
[[nodiscard]] std::vector<std::string> record_columns(const Record& record);

/// Prints a record as one line, unless its text is empty.
void print(const Record& record, const Output& output);

/// Prints the result of a command unless the output is quiet. A failure is printed in JSON only:
/// the caller of the command prints its message.
void print_answer(const Record& record, const client::Outcome& outcome, const Output& output);

/// As print_answer(), for a command that is done at a tick: adds its outcome and the tick.
client::Outcome report_tick(Record record, const client::Result<std::uint64_t>& tick,
                            const Output& output);

/// Adds the members of an object.
void add_members(Record& record, const Json& object);

/// @return a session as text, or null if there is none.
[[nodiscard]] Json session_json(std::uint64_t session);

/// @return the name of a session: program, process and host, or null.
[[nodiscard]] Json name_json(const std::optional<client::SessionName>& name);

/// Adds `outcome`; for a failure also `code` and `message`, and the owner of the axis, if known.
void add_outcome(Record& record, const client::Outcome& outcome);

}  // namespace vdrive::tool
