// SPDX-License-Identifier: Apache-2.0
#include "csv_field.hpp"

#include <cstddef>
#include <utility>

namespace vdrive::recording {
namespace {

/// Removes a quoted field and the comma after it from `line`.
std::string take_quoted(std::string_view& line) {
  std::string field;
  std::size_t place = 1;
  while (place < line.size()) {
    if (line[place] == '"') {
      ++place;
      if (place == line.size() || line[place] != '"') break;
    }
    field += line[place++];
  }
  line.remove_prefix(place);
  const std::size_t comma = line.find(',');
  field.append(line.substr(0, comma));
  line.remove_prefix(comma == std::string_view::npos ? line.size() : comma);
  return field;
}

}  // namespace

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::vector<std::string> csv_fields(std::string_view line) {
  std::vector<std::string> fields;
  while (true) {
    std::string field;
    if (line.starts_with('"')) {
      field = take_quoted(line);
    } else {
      field = line.substr(0, line.find(','));
      line.remove_prefix(field.size());
    }
    fields.push_back(std::move(field));
    if (line.empty()) return fields;
    line.remove_prefix(1);  // the comma
  }
}

}  // namespace vdrive::recording
