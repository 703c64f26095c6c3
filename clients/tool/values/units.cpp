// SPDX-License-Identifier: Apache-2.0
#include "values/units.hpp"

#include "base/usage_error.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <cmath>
#include <stdexcept>

namespace vdrive::tool {
namespace {

/// @throws UsageError with the typed text when the value is out of the range of the type.
std::int64_t rounded_quantity(const Quantity& quantity, double user_units, const Unit& unit,
                              std::string_view which) {
  const TypeRange range = range_of(quantity.type);
  const double nearest = std::round(user_units);
  const bool fits =
      nearest >= static_cast<double>(range.lowest) && nearest <= static_cast<double>(range.highest);
  if (fits) return static_cast<std::int64_t>(nearest);
  throw UsageError(in_quotes(quantity.text) + std::string(which) + " is " + to_text(nearest) +
                   " UU" + std::string(unit_ending(quantity.dimension)) + ": must be from " +
                   quantity_text(range.lowest, quantity.dimension, unit) + " to " +
                   quantity_text(range.highest, quantity.dimension, unit));
}

/// Hexadecimal numbers are the two's complement of the type.
WrittenQuantity as_written(std::string_view text, Dimension dimension, DataType type) {
  if (has_hex_prefix(text)) {
    return {static_cast<double>(parse_value(text, type)), "UU"};
  }
  try {
    return read_quantity(text, dimension);
  } catch (const std::invalid_argument& refusal) {
    throw UsageError(refusal.what());
  }
}

}  // namespace

Quantity parse_quantity(std::string_view text, Dimension dimension, DataType type) {
  Quantity quantity{as_written(text, dimension, type), std::string(text), dimension, type};
  if (quantity.is_in_user_units()) {
    static_cast<void>(rounded_quantity(quantity, quantity.value, user_unit(), ""));
  }
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
  if (!dimension || is_plain || has_hex_prefix(text)) {
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
                     " is a fraction: torque is in whole per mille of the rated torque; a "
                     "percentage such as 1.25% is rounded");
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
  const auto user_units = to_user_units(quantity, unit);
  if (!user_units) {
    throw UsageError(in_quotes(quantity.text) + ": axis " + std::string(axis) + " has no unit " +
                     in_quotes(quantity.unit) + "; it has " +
                     list_of_units(quantity.dimension, unit));
  }
  return rounded_quantity(quantity, *user_units, unit, " of axis " + std::string(axis));
}

}  // namespace vdrive::tool
