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

/// Where the commands of a session write what they answer.
struct Output {
  Terminal& terminal;
  bool is_json;         ///< one JSON object a line instead of text
  const bool is_quiet;  ///< only commands that read print; the others print nothing
};

/// One row of a record.
struct Field {
  std::string name;    ///< in JSON
  Json value;          ///< in JSON
  std::string text{};  ///< in the line of text, with its unit; empty = in JSON only
};

/// What a command answers: a table of its fields, in the order of both forms. A phrase that is
/// about several fields is the text of the last one.
using Record = std::vector<Field>;

/// @return the fields as an object; a name that occurs twice has its last value.
[[nodiscard]] Json record_json(const Record& record);

/// @return the texts of the fields with a blank between them.
[[nodiscard]] std::string record_text(const Record& record);

/// @return the texts of the fields that have one, as a row of a table.
[[nodiscard]] std::vector<std::string> record_columns(const Record& record);

/// Prints a record as one line; nothing in place of a text that is empty.
void print(const Record& record, const Output& output);

/// Prints what a command has done, unless the output is quiet. A failure is a line of JSON only:
/// the caller of the command prints its message.
void print_answer(const Record& record, const client::Outcome& outcome, const Output& output);

/// The same of a command that is done at a tick: adds its outcome, and the tick.
client::Outcome report_tick(Record record, const client::Result<std::uint64_t>& tick,
                            const Output& output);

/// Adds the members of an object.
void add_members(Record& record, const Json& object);

/// @return a session as text, or null where there is none.
[[nodiscard]] Json session_json(std::uint64_t session);

/// @return who a session is: program, process and host, or null.
[[nodiscard]] Json name_json(const std::optional<client::SessionName>& name);

/// Adds `outcome`, and for a failure `code` and `message`, and the session that stands in the way.
void add_outcome(Record& record, const client::Outcome& outcome);

}  // namespace vdrive::tool
