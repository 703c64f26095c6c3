// SPDX-License-Identifier: Apache-2.0
#include "values/value.hpp"

#include "base/usage_error.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/dictionary/standard_names.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace vdrive::tool {
namespace {

/// Objects whose bits matter more than their value.
constexpr std::array<std::uint16_t, 4> kWords{0x6040, 0x6041, 0x603F, 0x1000};

/// Common names of the values of a moving axis.
constexpr std::array kShortNames{
    StandardName{"position", "load_position_actual_value"},
    StandardName{"velocity", "load_velocity_actual_value"},
    StandardName{"torque", "torque_actual_value"},
    StandardName{"following_error", "load_position_error_value"},
    StandardName{"mode", "op_mode_actual"},
};

std::optional<ObjectRow> row_named(std::string_view name) {
  if (const auto row = find_named(name)) return row;
  const auto* const found = std::ranges::find(kShortNames, name, &StandardName::name);
  return found == kShortNames.end() ? std::nullopt : find_object(found->variable_name);
}

bool looks_like_name(std::string_view text) {
  const auto is_name_character = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  };
  return !text.empty() && text[0] >= 'a' && text[0] <= 'z' &&
         std::ranges::all_of(text, is_name_character);
}

/// Two's complement of `width` bytes.
std::int64_t sign_extended(std::uint64_t bits, std::uint8_t width) {
  const unsigned shift = 64U - 8U * width;
  return static_cast<std::int64_t>(bits << shift) >> shift;
}

std::string range_of_type(DataType type) {
  const TypeRange range = range_of(type);
  return std::to_string(range.lowest) + " to " + std::to_string(range.highest);
}

[[noreturn]] void refuse_too_wide(std::string_view text, DataType type) {
  std::string message = in_quotes(text) + " does not fit " + std::string(to_string(type)) + ": " +
                        range_of_type(type);
  if (has_hex_prefix(text)) {
    message += ", at most " + std::to_string(2 * size_of(type)) + " hex digits";
  }
  throw UsageError(message);
}

/// @param kind of a text that is not an integer of the type
[[noreturn]] void refuse_value(std::string_view text, IntegerKind kind, DataType type) {
  if (kind == IntegerKind::no_number) {
    throw UsageError(in_quotes(text) +
                     " is not a value: write a decimal number such as 1000 or 1e3, or hex such as "
                     "0x1F");
  }
  if (kind == IntegerKind::fraction) {
    throw UsageError(in_quotes(text) + " is a fraction: the object is " +
                     std::string(to_string(type)) + " and takes whole numbers from " +
                     range_of_type(type));
  }
  refuse_too_wide(text, type);
}

}  // namespace

std::optional<ObjectRow> ObjectName::row() const {
  return address ? find_object(*address) : std::nullopt;
}

bool ObjectName::covers(ObjectAddress other) const {
  if (!address || address->index != other.index) return false;
  const auto spelled = parse_address(text);
  const bool is_whole_index = spelled && !spelled->subindex;
  return is_whole_index || address->subindex == other.subindex;
}

ObjectName parse_object(std::string_view text) {
  if (const auto spelled = parse_address(text)) return {std::string(text), spelled->address()};
  if (looks_like_name(text)) {
    const auto row = row_named(text);
    if (!row) return {std::string(text), std::nullopt};
    return {std::string(text), describe(*row).address};
  }
  throw UsageError(in_quotes(text) + " is not an object" + address_suggestion(text) +
                   ": write 0x6041, 0x607D:1 or a variable_name such as ds402_statusword");
}

std::vector<ObjectName> parse_objects(const std::vector<std::string>& texts) {
  std::vector<ObjectName> objects;
  objects.reserve(texts.size());
  for (const std::string& text : texts) objects.push_back(parse_object(text));
  return objects;
}

std::string object_suggestion(std::string_view name) {
  std::vector<std::string> names = names_of_objects();
  for (const StandardName& each : kShortNames) names.emplace_back(each.name);
  return suggestion(name, names);
}

std::int64_t parse_value(std::string_view text, DataType type) {
  const TypeRange range = range_of(type);
  const IntegerReading number = read_integer(text);
  if (number.kind != IntegerKind::whole) refuse_value(text, number.kind, type);
  if (has_hex_prefix(text)) {
    const auto bits = static_cast<std::uint64_t>(number.value);
    const std::uint64_t highest = (std::uint64_t{1} << (8U * size_of(type))) - 1;
    if (bits > highest) refuse_too_wide(text, type);
    return range.lowest < 0 ? sign_extended(bits, size_of(type)) : number.value;
  }
  if (number.value < range.lowest || number.value > range.highest) refuse_too_wide(text, type);
  return number.value;
}

std::int64_t parse_value(std::string_view text, const ObjectName& object) {
  const auto row = object.row();
  if (row) return parse_value(text, describe(*row).data_type);
  return parse_value(text, text.starts_with('-') ? DataType::integer32 : DataType::unsigned32);
}

std::string value_text(const ObjectName& object, std::int64_t value, const Unit& unit) {
  const auto row = object.row();
  const std::string text = row ? object_value_text(*row, value, unit) : std::to_string(value);
  const bool is_word =
      object.address && std::ranges::find(kWords, object.address->index) != kWords.end();
  return is_word ? hex(static_cast<std::uint64_t>(value), 3) + " (" + text + ")" : text;
}

std::uint64_t parse_number(std::string_view text, std::string_view what, std::uint64_t highest) {
  const auto number = parse_integer(text);
  if (!number || *number < 0 || static_cast<std::uint64_t>(*number) > highest) {
    throw UsageError(in_quotes(text) + " is not a valid " + std::string(what) +
                     ": write a whole number from 0 to " + std::to_string(highest));
  }
  return static_cast<std::uint64_t>(*number);
}

Duration parse_duration(std::string_view text) {
  const auto duration = vdrive::parse_duration(text);
  if (!duration) {
    throw UsageError(in_quotes(text) +
                     " is not a duration: write for example 500us, 20ms, 1.5s or 2min, at most " +
                     std::to_string(kLongestDuration.count()) +
                     " hours; a number without a unit is in seconds");
  }
  return *duration;
}

double parse_real(std::string_view text, std::string_view what) {
  const auto value = vdrive::parse_number(text);
  if (!value) {
    throw UsageError(in_quotes(text) + " is not a valid " + std::string(what) +
                     ": write a number such as 0.5");
  }
  return *value;
}

ObjectRow checked_row(const ObjectName& object) {
  if (const auto row = object.row()) return *row;
  const std::string advice =
      object.address ? advice_on(*object.address, check_address(*object.address)) : "";
  throw UsageError(in_quotes(object.text) + " is not an object of the dictionary" +
                   object_suggestion(object.text) +
                   (advice.empty() ? "; 'vdrive dictionary' lists all objects" : ": " + advice));
}

void check_value_written(const ObjectName& object, std::int64_t value) {
  const ObjectRow row = checked_row(object);
  const AbortCode code = check_write(row, value);
  if (code == AbortCode::none) return;
  if (code == AbortCode::write_of_read_only_object) {
    throw UsageError(in_quotes(object.text) + " is read-only");
  }
  throw UsageError(std::to_string(value) + " is out of range: " + range_text(row));
}

std::string range_text(ObjectRow row) {
  const ObjectDescription& object = describe(row);
  return std::string(object.variable_name) + " has " + values_text(row);
}

}  // namespace vdrive::tool
