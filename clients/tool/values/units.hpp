// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "values/value.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/dictionary/object.hpp"
#include "vdrive/quantity.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::tool {

/// A position, a speed, a ramp or a jerk as typed. The unit of its axis converts it to user units.
struct Quantity : WrittenQuantity {
  std::string text;
  Dimension dimension = Dimension::position;
  DataType type = DataType::integer32;  ///< type that must hold it
};

/// @param text a number such as -500, 1e4, 0xFFFFD8F0 (two's complement of `type`), with or without
///        a unit: 90deg, 180deg/s, 900deg/s2, 9000deg/s3, 300rpm
/// @throws UsageError for anything else, and for user units out of the range of `type`.
[[nodiscard]] Quantity parse_quantity(std::string_view text, Dimension dimension, DataType type);

/// A position [UU], and a signed velocity [UU/s]. @throws UsageError
[[nodiscard]] Quantity parse_position(std::string_view text);
[[nodiscard]] Quantity parse_velocity(std::string_view text);

/// A speed [UU/s] and a ramp [UU/s²], both unsigned. @throws UsageError
[[nodiscard]] Quantity parse_speed(std::string_view text);
[[nodiscard]] Quantity parse_ramp(std::string_view text);

/// @return the value for an object, if it was typed with a unit or an exponent.
/// @throws UsageError for a unit that no such object has.
[[nodiscard]] std::optional<Quantity> parse_quantity(const std::string& text,
                                                     const ObjectName& object);

/// @param text [per mille of rated torque], or a percentage such as 12.5%
/// @return [per mille of rated torque], rounded to the nearest.
/// @throws UsageError for anything else, and beyond the range of INTEGER16.
[[nodiscard]] std::int16_t parse_torque(std::string_view text);

/// @param axis name of the axis in messages
/// @return [UU], rounded to the nearest.
/// @throws UsageError if the axis does not have the unit, with those that it has, or if the value
///         is out of the range of the type.
[[nodiscard]] std::int64_t user_units_of(const Quantity& quantity, const client::Unit& unit,
                                         std::string_view axis);

}  // namespace vdrive::tool
