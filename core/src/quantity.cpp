// SPDX-License-Identifier: Apache-2.0
#include "vdrive/quantity.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace vdrive {
namespace {

constexpr double kSecondsAMinute = 60.0;
constexpr std::string_view kUserUnitName = "UU";
constexpr std::string_view kTurnsAMinute = "rpm";

/// Name and notation of a dimension.
struct DimensionWords {
  std::string_view name;
  std::string_view units;                   ///< the prefixes of ObjectDescription::units
  std::array<std::string_view, 3> endings;  ///< after the unit of a position; texts use the first
  std::string_view example;
};

constexpr std::array kDimensions{
    DimensionWords{"position", "Pos", {"", "", ""}, "1024, 90deg or 12.5mm"},
    DimensionWords{"speed", "Vel", {"/s", "/s", "/s"}, "1000, 180deg/s or 5mm/s"},
    DimensionWords{"ramp", "Acc", {"/s2", "/s^2", "/s\u00B2"}, "6000, 900deg/s2 or 50mm/s2"},
    DimensionWords{"jerk", "Jerk", {"/s3", "/s^3", "/s\u00B3"}, "60000, 9000deg/s3 or 500mm/s3"}};

const DimensionWords& words_of(Dimension dimension) {
  const auto row = static_cast<std::size_t>(dimension);
  ensure(row < kDimensions.size(), "each dimension has a row");
  return kDimensions[row];
}

[[noreturn]] void refuse_text(std::string_view text, Dimension dimension) {
  const DimensionWords& words = words_of(dimension);
  throw std::invalid_argument(in_quotes(text) + " is not a " + std::string(words.name) +
                              ": write for example " + std::string(words.example));
}

/// A drive has no half user unit: rounding silently would not do what was written.
[[noreturn]] void refuse_fraction(std::string_view text, Dimension dimension) {
  throw std::invalid_argument(
      in_quotes(text) + " is a fraction, but user units are whole numbers: write for example " +
      std::string(words_of(dimension).example) + "; a value with a unit is rounded");
}

/// @return the unit of the position in `suffix`, the text after the number.
std::string unit_of(std::string_view suffix, std::string_view text, Dimension dimension) {
  suffix.remove_prefix(std::min(suffix.find_first_not_of(' '), suffix.size()));
  if (suffix.empty()) return std::string(kUserUnitName);
  if (dimension == Dimension::velocity && suffix == kTurnsAMinute) return std::string(suffix);
  const auto& endings = words_of(dimension).endings;
  const auto ending = std::ranges::find_if(endings, [suffix](std::string_view each) {
    return suffix.ends_with(each);
  });
  if (ending == endings.end()) refuse_text(text, dimension);
  suffix.remove_suffix(ending->size());
  if (suffix.empty() || suffix.find('/') != std::string_view::npos) refuse_text(text, dimension);
  return std::string(suffix);
}

}  // namespace

WrittenQuantity read_quantity(std::string_view text, Dimension dimension) {
  WrittenQuantity quantity;
  const std::size_t length = decimal_length(text);
  const auto value = parse_number(text.substr(0, length));
  if (!value) refuse_text(text, dimension);
  quantity.value = *value;
  quantity.unit = unit_of(text.substr(length), text, dimension);
  const bool is_fraction = quantity.value != std::trunc(quantity.value);
  if (quantity.is_in_user_units() && is_fraction) refuse_fraction(text, dimension);
  return quantity;
}

std::optional<double> to_user_units(const WrittenQuantity& quantity, const Unit& unit) {
  const bool counts_turns = quantity.unit == kTurnsAMinute;
  const auto size = user_units_in(unit, counts_turns ? "rev" : std::string_view(quantity.unit));
  if (!size) return std::nullopt;
  return quantity.value * (counts_turns ? *size / kSecondsAMinute : *size);
}

std::string list_of_units(Dimension dimension, const Unit& unit) {
  const std::string ending(unit_ending(dimension));
  std::string list;
  for (const std::string& name : units_of(unit)) list += escaped(name) + ending + ", ";
  const bool has_turns = dimension == Dimension::velocity && unit.kind == UnitKind::rotary;
  if (has_turns) list.append(kTurnsAMinute).append(", ");
  return list.append(kUserUnitName).append(ending);
}

std::string_view unit_ending(Dimension dimension) noexcept {
  return words_of(dimension).endings.front();
}

Unit user_unit() {
  return {.kind = UnitKind::linear, .name = std::string(kUserUnitName), .size = 1.0};
}

std::string unit_name(Dimension dimension, const Unit& unit) {
  return escaped(unit.name) + std::string(unit_ending(dimension));
}

std::string quantity_text(std::int64_t user_units, Dimension dimension, const Unit& unit) {
  const std::string ending(unit_ending(dimension));
  std::string text = std::to_string(user_units) + " " + std::string(kUserUnitName) + ending;
  if (unit.name == kUserUnitName) return text;
  return text + " (" + escaped(position_text(user_units, unit)) + ending + ")";
}

std::optional<Dimension> dimension_of(ObjectRow row) noexcept {
  const std::string_view units = describe(row).units;
  if (units == "p") return Dimension::position;  // 607Dh, as in the manual
  for (const Dimension dimension :
       {Dimension::position, Dimension::velocity, Dimension::acceleration, Dimension::jerk}) {
    if (units.starts_with(words_of(dimension).units)) return dimension;
  }
  return std::nullopt;
}

std::string object_value_text(ObjectRow row, std::int64_t value, const Unit& unit) {
  const auto dimension = dimension_of(row);
  return dimension ? quantity_text(value, *dimension, unit) : std::to_string(value);
}

std::string advice_on(ObjectAddress object, AbortCode code, const Unit& unit) {
  std::string plain = advice_on(object, code);
  const auto row = find_object(object);
  const bool is_of_limits = code != AbortCode::subindex_does_not_exist && !plain.empty();
  if (!is_of_limits || !row || !dimension_of(*row)) return plain;
  const ObjectDescription& limited = describe(*row);
  return std::string(limited.variable_name) + " accepts " +
         object_value_text(*row, limited.lower_limit, unit) + " to " +
         object_value_text(*row, limited.upper_limit, unit);
}

}  // namespace vdrive
