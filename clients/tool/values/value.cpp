// SPDX-License-Identifier: Apache-2.0
#include "values/value.hpp"

#include "base/usage_error.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/dictionary/standard_names.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <vector>

namespace vdrive::tool {
namespace {

/// Objects whose bits matter more than their value.
constexpr std::array<std::uint16_t, 4> kWords{0x6040, 0x6041, 0x603F, 0x1000};

constexpr std::int64_t kHighestHours = 1000;
constexpr std::int64_t kHighestNanoseconds = kHighestHours * 3600 * 1'000'000'000;

/// What people call the values of a moving axis.
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

bool is_hexadecimal(std::string_view text) {
  return text.size() > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
}

std::optional<std::uint64_t> unsigned_number(std::string_view text) {
  return is_hexadecimal(text) ? parse_digits<std::uint64_t>(text.substr(2), 16)
                              : parse_digits<std::uint64_t>(text);
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

[[noreturn]] void throw_too_wide(std::string_view text, DataType type) {
  const TypeRange range = range_of(type);
  std::string message = in_quotes(text) + " does not fit " + std::string(to_string(type)) + ": " +
                        std::to_string(range.lowest) + " to " + std::to_string(range.highest);
  if (is_hexadecimal(text))
    message += ", at most " + std::to_string(2 * size_of(type)) + " hex digits";
  throw UsageError(message);
}

std::int64_t decimal_value(std::string_view text) {
  std::int64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (stop == end && error == std::errc::result_out_of_range) {
    return text[0] == '-' ? std::numeric_limits<std::int64_t>::min()
                          : std::numeric_limits<std::int64_t>::max();
  }
  if (error != std::errc{} || stop != end) {
    throw UsageError(in_quotes(text) +
                     " is not a value: write a decimal number or hex such as 0x1F");
  }
  return value;
}

/// Decimal digits with an optional fraction, times `unit`, exactly; a fraction of 1 ns is rounded
/// up.
std::optional<std::chrono::nanoseconds> scaled(std::string_view text, std::int64_t unit) {
  const std::size_t dot = std::min(text.find('.'), text.size());
  const auto whole = parse_digits<std::uint64_t>(text.substr(0, dot));
  if (!whole || *whole > static_cast<std::uint64_t>(kHighestNanoseconds / unit))
    return std::nullopt;
  std::int64_t nanoseconds = static_cast<std::int64_t>(*whole) * unit;
  if (dot == text.size()) return std::chrono::nanoseconds(nanoseconds);
  const std::string_view fraction = text.substr(dot + 1);
  const auto numerator = parse_digits<std::uint64_t>(fraction);
  if (!numerator || fraction.size() > 9) return std::nullopt;
  std::int64_t denominator = 1;
  for (std::size_t i = 0; i < fraction.size(); ++i) denominator *= 10;
  const std::int64_t product = static_cast<std::int64_t>(*numerator) * (unit / 1000);
  // unit is a multiple of 1000 and the fraction has at most nine digits: no overflow.
  nanoseconds += (product * 1000 / denominator) + (product * 1000 % denominator != 0 ? 1 : 0);
  return std::chrono::nanoseconds(nanoseconds);
}

struct Unit {
  std::string_view suffix;
  std::int64_t nanoseconds;
};

constexpr std::array kUnits{Unit{"us", 1000}, Unit{"ms", 1'000'000}, Unit{"s", 1'000'000'000}};

std::optional<std::chrono::nanoseconds> duration_of(std::string_view text) {
  for (const Unit& unit : kUnits) {
    if (!text.ends_with(unit.suffix)) continue;
    text.remove_suffix(unit.suffix.size());
    const auto duration = scaled(text, unit.nanoseconds);
    if (duration && *duration <= std::chrono::hours(kHighestHours)) return duration;
    return std::nullopt;
  }
  return std::nullopt;
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
  throw UsageError(in_quotes(text) +
                   " is not an object: write 0x6041, 0x607D:1 or a variable_name such as "
                   "ds402_statusword");
}

std::vector<ObjectName> parse_objects(const std::vector<std::string>& texts) {
  std::vector<ObjectName> objects;
  objects.reserve(texts.size());
  for (const std::string& text : texts) objects.push_back(parse_object(text));
  return objects;
}

std::string object_suggestion(std::string_view name) {
  std::vector<std::string> names;
  names.reserve(kObjectTable.size() + kStandardNames.size() + kShortNames.size());
  for (const ObjectDescription& row : kObjectTable) names.emplace_back(row.variable_name);
  for (const StandardName& standard : kStandardNames) names.emplace_back(standard.name);
  for (const StandardName& each : kShortNames) names.emplace_back(each.name);
  return suggestion(name, names);
}

std::int64_t parse_value(std::string_view text, DataType type) {
  const TypeRange range = range_of(type);
  if (is_hexadecimal(text)) {
    const auto bits = unsigned_number(text);
    if (!bits && text.find_first_not_of("0123456789abcdefABCDEF", 2) != std::string_view::npos) {
      throw UsageError(in_quotes(text) +
                       " is not a value: write a decimal number or hex such as 0x1F");
    }
    const std::uint64_t highest = (std::uint64_t{1} << (8U * size_of(type))) - 1;
    if (!bits || *bits > highest) throw_too_wide(text, type);
    return range.lowest < 0 ? sign_extended(*bits, size_of(type))
                            : static_cast<std::int64_t>(*bits);
  }
  const std::int64_t value = decimal_value(text);
  if (value < range.lowest || value > range.highest) throw_too_wide(text, type);
  return value;
}

std::int64_t parse_value(std::string_view text, const ObjectName& object) {
  const auto row = object.row();
  if (row) return parse_value(text, describe(*row).data_type);
  const bool is_negative = !text.empty() && text[0] == '-';
  return parse_value(text, is_negative ? DataType::integer32 : DataType::unsigned32);
}

std::string value_text(const ObjectName& object, std::int64_t value) {
  const std::string text = std::to_string(value);
  const bool is_word =
      object.address && std::ranges::find(kWords, object.address->index) != kWords.end();
  return is_word ? hex(static_cast<std::uint64_t>(value), 3) + " (" + text + ")" : text;
}

std::uint64_t parse_number(std::string_view text, std::string_view what, std::uint64_t highest) {
  const auto number = unsigned_number(text);
  if (!number || *number > highest) {
    throw UsageError(in_quotes(text) + " is not a valid " + std::string(what) +
                     ": write a number from 0 to " + std::to_string(highest));
  }
  return *number;
}

std::chrono::nanoseconds parse_duration(std::string_view text) {
  const auto duration = duration_of(text);
  if (!duration) {
    throw UsageError(in_quotes(text) +
                     " is not a duration: write for example 500us, 20ms or 1.5s, at most " +
                     std::to_string(kHighestHours) + " hours");
  }
  return *duration;
}

std::chrono::nanoseconds parse_seconds(std::string_view text) {
  auto duration = duration_of(text);
  if (!duration) duration = duration_of(std::string(text) + "s");
  if (!duration) {
    throw UsageError(in_quotes(text) + " is not a time: write seconds such as 2 or 0.5, or 500ms");
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

}  // namespace vdrive::tool
