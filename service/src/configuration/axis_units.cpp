// SPDX-License-Identifier: Apache-2.0
#include "configuration/axis_units.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;

std::string in_limits(const settings::IntegerLimits& limits, Dimension dimension,
                      const Unit& unit) {
  return "from " + quantity_text(limits.lowest, dimension, unit) + " to " +
         quantity_text(limits.highest, dimension, unit);
}

std::optional<WrittenQuantity> quantity_in(const std::string& text, Dimension dimension) {
  try {
    return read_quantity(text, dimension);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

}  // namespace

std::int64_t read_user_units(const settings::YamlValue& value, Dimension dimension,
                             const Unit& unit, const settings::IntegerLimits& limits) {
  const std::string text = value.text();
  if (const auto number = parse_integer(text)) {
    if (*number >= limits.lowest && *number <= limits.highest) return *number;
    value.refuse("must be a whole number " + in_limits(limits, dimension, unit));
  }
  const auto quantity = quantity_in(text, dimension);
  if (!quantity) {
    value.refuse("must be a whole number " + in_limits(limits, dimension, unit) +
                 ", or a value with a unit of the axis: " + list_of_units(dimension, unit));
  }
  const auto user_units = to_user_units(*quantity, unit);
  if (!user_units) {
    value.refuse("the axis has no such unit; it has " + list_of_units(dimension, unit));
  }
  const double nearest = std::round(*user_units);
  if (nearest < static_cast<double>(limits.lowest) ||
      nearest > static_cast<double>(limits.highest)) {
    value.refuse("is " + to_text(nearest) + " UU" + std::string(unit_ending(dimension)) +
                 ": must be " + in_limits(limits, dimension, unit));
  }
  return static_cast<std::int64_t>(nearest);
}

std::optional<std::int64_t> given_value(const AxisConfiguration& axis, ObjectRow row) {
  const ObjectAddress address = describe(row).address;
  const auto found = std::find_if(axis.parameters.rbegin(), axis.parameters.rend(),
                                  [address](const InitialValue& parameter) {
                                    return parameter.address == address;
                                  });
  return found == axis.parameters.rend() ? std::nullopt : std::optional(found->value);
}

std::int64_t value_at_start(const AxisConfiguration& axis, ObjectRow row) {
  return given_value(axis, row).value_or(describe(row).default_value);
}

double gear_ratio_of(const AxisConfiguration& axis) {
  return static_cast<double>(value_at_start(axis, "gear_ratio_numerator"_object)) /
         static_cast<double>(value_at_start(axis, "gear_ratio_denominator"_object));
}

double user_units_per_load_turn(const AxisConfiguration& axis) {
  const bool at_motor = axis.model.feedback == Feedback::single_encoder;
  return at_motor ? kUserUnitsPerRevolution / gear_ratio_of(axis) : kUserUnitsPerRevolution;
}

double highest_motor_velocity(const AxisConfiguration& axis) {
  return velocity_of_motor(static_cast<double>(value_at_start(axis, "motor_max_speed_rpm"_object)),
                           axis.model.feedback, gear_ratio_of(axis));
}

std::string six_digits(double value) {
  std::array<char, 32> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6);
  return {text.data(), end.ptr};
}

}  // namespace vdrive::service
