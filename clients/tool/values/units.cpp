// SPDX-License-Identifier: Apache-2.0
#include "values/units.hpp"

#include "base/usage_error.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

namespace vdrive::tool {
namespace {

constexpr double kSecondsAMinute = 60.0;
constexpr std::string_view kUserUnit = "UU";
constexpr std::string_view kTurnsAMinute = "rpm";

/// How a dimension is called and typed.
struct DimensionWords {
  std::string_view name;
  std::string_view units;                   ///< the prefixes of ObjectDescription::units
  std::array<std::string_view, 3> endings;  ///< behind the unit of a position; the first is shown
  std::string_view example;
};

constexpr std::array kDimensions{
    DimensionWords{"position", "Pos", {"", "", ""}, "1024, 90deg or 12.5mm"},
    DimensionWords{"speed", "Vel", {"/s", "/s", "/s"}, "1000, 180deg/s or 5mm/s"},
    DimensionWords{"ramp", "Acc", {"/s2", "/s^2", "/s\u00B2"}, "6000, 900deg/s2 or 50mm/s2"}};

const DimensionWords& words_of(Dimension dimension) {
  const auto row = static_cast<std::size_t>(dimension);
  ensure(row < kDimensions.size(), "each dimension has a row");
  return kDimensions[row];
}

[[noreturn]] void refuse_text(std::string_view text, Dimension dimension) {
  const DimensionWords& words = words_of(dimension);
  throw UsageError(in_quotes(text) + " is not a " + std::string(words.name) +
                   ": write for example " + std::string(words.example));
}

/// A drive has no half of a user unit: it would do something else than was written.
[[noreturn]] void refuse_fraction(std::string_view text, Dimension dimension) {
  throw UsageError(in_quotes(text) +
                   " is a fraction: user units are whole numbers; a value with a unit of the axis, "
                   "for example " +
                   std::string(words_of(dimension).example) + ", is rounded to them");
}

/// @return the unit of the position behind the number.
std::string unit_of(std::string_view suffix, std::string_view text, Dimension dimension) {
  suffix.remove_prefix(std::min(suffix.find_first_not_of(' '), suffix.size()));
  if (suffix.empty()) return std::string(kUserUnit);
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

/// @throws UsageError naming what was typed when the type does not hold the value.
std::int64_t rounded_quantity(const Quantity& quantity, double user_units, std::string_view which) {
  const TypeRange range = range_of(quantity.type);
  const double nearest = std::round(user_units);
  const bool fits =
      nearest >= static_cast<double>(range.lowest) && nearest <= static_cast<double>(range.highest);
  if (fits) return static_cast<std::int64_t>(nearest);
  const std::string ending(words_of(quantity.dimension).endings.front());
  throw UsageError(in_quotes(quantity.text) + std::string(which) + " is " + to_text(nearest) +
                   " UU" + ending + ": must be from " + std::to_string(range.lowest) + " to " +
                   std::to_string(range.highest) + " UU" + ending);
}

std::optional<double> size_of_unit(const Quantity& quantity, const client::Unit& unit) {
  if (quantity.unit != kTurnsAMinute) return user_units_in(unit, quantity.unit);
  const auto turn = user_units_in(unit, "rev");
  return turn ? std::optional(*turn / kSecondsAMinute) : std::nullopt;
}

std::string list_of_units(Dimension dimension, const client::Unit& unit) {
  const std::string ending(words_of(dimension).endings.front());
  std::string list;
  for (const std::string& name : units_of(unit)) list += escaped(name) + ending + ", ";
  const bool has_turns = dimension == Dimension::velocity && unit.kind == client::UnitKind::rotary;
  if (has_turns) list.append(kTurnsAMinute).append(", ");
  return list.append(kUserUnit).append(ending);
}

}  // namespace

Quantity parse_quantity(std::string_view text, Dimension dimension, DataType type) {
  Quantity quantity{.text = std::string(text),
                    .dimension = dimension,
                    .type = type,
                    .value = 0.0,
                    .unit = std::string(kUserUnit)};
  if (text.starts_with("0x") || text.starts_with("0X")) {
    quantity.value = static_cast<double>(parse_value(text, type));
    return quantity;
  }
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, quantity.value);
  // from_chars takes "inf" and "nan" too, and what no double holds is none of these quantities.
  if (error != std::errc{} || !std::isfinite(quantity.value)) refuse_text(text, dimension);
  quantity.unit = unit_of({stop, static_cast<std::size_t>(end - stop)}, text, dimension);
  if (!quantity.is_in_user_units()) return quantity;
  if (quantity.value != std::trunc(quantity.value)) refuse_fraction(text, dimension);
  static_cast<void>(rounded_quantity(quantity, quantity.value, ""));
  return quantity;
}

Quantity parse_position(std::string_view text) {
  return parse_quantity(text, Dimension::position, DataType::integer32);
}

Quantity parse_velocity(std::string_view text) {
  return parse_quantity(text, Dimension::velocity, DataType::integer32);
}

Quantity parse_speed(std::string_view text) {
  return parse_quantity(text, Dimension::velocity, DataType::unsigned32);
}

Quantity parse_ramp(std::string_view text) {
  return parse_quantity(text, Dimension::acceleration, DataType::unsigned32);
}

std::optional<Quantity> parse_quantity(const std::string& text, const ObjectName& object) {
  const auto row = object.row();
  const auto dimension = row ? dimension_of(*row) : std::nullopt;
  const bool is_plain = text.find_first_not_of("-0123456789") == std::string::npos;
  if (!dimension || is_plain || text.starts_with("0x") || text.starts_with("0X")) {
    return std::nullopt;
  }
  return parse_quantity(text, *dimension, describe(*row).data_type);
}

std::int16_t parse_torque(std::string_view text) {
  constexpr double kPerMilleAPercent = 10.0;
  const bool is_percent = text.ends_with('%');
  const auto number = vdrive::parse_number(text.substr(0, text.size() - (is_percent ? 1 : 0)));
  if (!number) {
    throw UsageError(in_quotes(text) +
                     " is not a torque: write per mille of the rated torque such as 100, or 10%");
  }
  if (!is_percent && *number != std::trunc(*number)) {
    throw UsageError(in_quotes(text) +
                     " is a fraction: per mille of the rated torque are whole numbers; a value in "
                     "per cent such as 1.25% is rounded to them");
  }
  const double torque = std::round(*number * (is_percent ? kPerMilleAPercent : 1.0));
  const TypeRange range = range_of(DataType::integer16);
  if (torque < static_cast<double>(range.lowest) || torque > static_cast<double>(range.highest)) {
    throw UsageError(in_quotes(text) + " is out of range: a torque is from " +
                     std::to_string(range.lowest) + " to " + std::to_string(range.highest) +
                     " per mille of the rated torque");
  }
  return static_cast<std::int16_t>(torque);
}

std::int64_t user_units_of(const Quantity& quantity, const client::Unit& unit,
                           std::string_view axis) {
  const auto size = size_of_unit(quantity, unit);
  if (!size) {
    throw UsageError(in_quotes(quantity.text) + ": axis " + std::string(axis) + " has no unit " +
                     in_quotes(quantity.unit) + "; it has " +
                     list_of_units(quantity.dimension, unit));
  }
  return rounded_quantity(quantity, quantity.value * *size, " of axis " + std::string(axis));
}

std::optional<Dimension> dimension_of(ObjectRow row) {
  const std::string_view units = describe(row).units;
  if (units == "p") return Dimension::position;  // 607Dh, as the manual has it
  for (const Dimension dimension :
       {Dimension::position, Dimension::velocity, Dimension::acceleration}) {
    if (units.starts_with(words_of(dimension).units)) return dimension;
  }
  return std::nullopt;
}

}  // namespace vdrive::tool
