// SPDX-License-Identifier: Apache-2.0
#include "output/record.hpp"

#include "vdrive/number_text.hpp"

namespace vdrive::tool {

Json record_json(const Record& record) {
  Json json = Json::object();
  for (const Field& field : record) json[field.name] = field.value;
  return json;
}

std::vector<std::string> record_columns(const Record& record) {
  std::vector<std::string> columns;
  for (const Field& field : record) {
    if (!field.text.empty()) columns.push_back(field.text);
  }
  return columns;
}

std::string record_text(const Record& record) {
  std::string line;
  for (const std::string& text : record_columns(record)) line += (line.empty() ? "" : " ") + text;
  return line;
}

void print(const Record& record, const Output& output) {
  const std::string line = output.is_json ? to_line(record_json(record)) : record_text(record);
  if (!line.empty()) output.terminal.print(line);
}

void print_answer(const Record& record, const client::Outcome& outcome, const Output& output) {
  if (!output.is_quiet && (output.is_json || outcome)) print(record, output);
}

client::Outcome report_tick(Record record, const client::Result<std::uint64_t>& tick,
                            const Output& output) {
  add_outcome(record, tick.outcome());
  if (tick) record.push_back({"tick", *tick, "tick " + std::to_string(*tick)});
  print_answer(record, tick.outcome(), output);
  return tick.outcome();
}

void add_members(Record& record, const Json& object) {
  for (const auto& [name, value] : object.items()) record.push_back({name, value});
}

Json session_json(std::uint64_t session) {
  return session == 0 ? Json(nullptr) : Json(session_text(session));
}

Json name_json(const std::optional<client::SessionName>& name) {
  if (!name) return nullptr;
  return {{"program", name->program}, {"process", name->process}, {"host", name->host}};
}

void add_outcome(Record& record, const client::Outcome& outcome) {
  record.push_back({"outcome", to_string(outcome.kind())});
  if (outcome) return;
  if (outcome.code() != 0) record.push_back({"code", hex(outcome.code(), 8)});
  record.push_back({"message", outcome.message()});
  if (const client::AxisOwner* const owner = outcome.owner()) {
    record.push_back({"owner", session_json(owner->session)});
    record.push_back({"owner_name", name_json(owner->name)});
  }
}

}  // namespace vdrive::tool
