// SPDX-License-Identifier: Apache-2.0
#include "node/data_sheet_reader.hpp"

#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>

namespace vdrive::canopen {
namespace {

/// The numeric data types of CiA 301.
struct SheetType {
  std::uint16_t number = 0;
  std::uint8_t size = 0;  // [bytes]
  bool is_signed = false;
};

constexpr std::array kSheetTypes{
    SheetType{0x0001, 1, false},  // BOOLEAN
    SheetType{0x0002, 1, true},  SheetType{0x0003, 2, true},  SheetType{0x0004, 4, true},
    SheetType{0x0005, 1, false}, SheetType{0x0006, 2, false}, SheetType{0x0007, 4, false},
    SheetType{0x0010, 3, true},  SheetType{0x0015, 8, true},  SheetType{0x0016, 3, false},
    SheetType{0x001B, 8, false},
};

const SheetType* find_sheet_type(std::uint16_t number) {
  const auto type = std::ranges::find(kSheetTypes, number, &SheetType::number);
  return type == kSheetTypes.end() ? nullptr : &*type;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view kSheetBlanks = " \t\r";
  const std::size_t first = text.find_first_not_of(kSheetBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSheetBlanks) - first + 1);
}

/// @param name in lower case, such as "607dsub1"
std::optional<ObjectAddress> section_address(std::string_view name) {
  constexpr std::size_t kIndexDigits = 4;
  constexpr std::string_view kSub = "sub";
  constexpr int kHex = 16;
  if (name.size() < kIndexDigits) return std::nullopt;
  const auto index = parse_digits<std::uint16_t>(name.substr(0, kIndexDigits), kHex);
  if (!index) return std::nullopt;
  name.remove_prefix(kIndexDigits);
  if (name.empty()) return ObjectAddress{*index, 0};
  if (!name.starts_with(kSub)) return std::nullopt;
  const auto subindex = parse_digits<std::uint8_t>(name.substr(kSub.size()), kHex);
  return subindex ? std::optional(ObjectAddress{*index, *subindex}) : std::nullopt;
}

/// Reads a number of CiA 306: C notation, but 037 is read as 37, because nobody means octal.
void read_value(std::string_view text, SheetObject& object) {
  const std::string lower = lower_case(text);
  const std::size_t node_id = lower.find("$nodeid");
  if (node_id == std::string::npos) {
    if (const auto value = parse_integer(text)) object.value = value;
    return;
  }
  // "$NODEID+0x180" or "0x180+$NODEID".
  std::string rest = lower;
  rest.erase(node_id, std::string_view("$nodeid").size());
  std::erase(rest, '+');
  std::erase(rest, ' ');
  object.has_node_id = true;
  object.value = rest.empty() ? 0 : parse_integer(rest).value_or(0);
}

void read_key(std::string_view line, SheetObject& object) {
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) return;
  const std::string key = lower_case(without_blanks(line.substr(0, equals)));
  const std::string_view value = without_blanks(line.substr(equals + 1));
  if (key == "datatype") {
    const auto type = parse_integer(value);
    if (type && *type > 0 && *type <= 0xFFFF) object.data_type = static_cast<std::uint16_t>(*type);
  } else if (key == "parametervalue" || (key == "defaultvalue" && !object.value)) {
    read_value(value, object);
  }
}

}  // namespace

std::uint8_t SheetObject::size() const noexcept {
  const SheetType* const type = find_sheet_type(data_type);
  return type == nullptr ? std::uint8_t{0} : type->size;
}

bool SheetObject::is_signed() const noexcept {
  const SheetType* const type = find_sheet_type(data_type);
  return type != nullptr && type->is_signed;
}

DataSheet read_data_sheet(std::string_view text) {
  DataSheet sheet;
  SheetObject* section = nullptr;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = without_blanks(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with('[')) {
      const std::string name = lower_case(line.substr(1, line.find(']') - 1));
      const auto address = section_address(name);
      section = address ? &sheet[*address] : nullptr;
    } else if (section != nullptr && !line.starts_with(';')) {
      read_key(line, *section);
    }
  }
  if (sheet.empty())
    throw DataSheetError("it describes no object: it has no section such as [6040]");
  return sheet;
}

}  // namespace vdrive::canopen
