// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "configuration/configuration.hpp"
#include "settings/yaml_reader.hpp"
#include "vdrive/dictionary/object.hpp"
#include "vdrive/quantity.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace vdrive::service {

// Values of an axis in its user units, as a configuration gives them.

/// Two unit sizes are equal if their ratio differs from 1 by less than this, because files give
/// rounded decimals.
inline constexpr double kSameSize = 1.0e-6;

/// Reads a whole number of user units, or a value with a unit of the axis, such as 4096, 25mm or
/// 250mm/s.
/// @return [UU], rounded to the nearest whole number
/// @throws ConfigurationError for anything else, a unit that the axis does not have, and a value
///         outside the limits
[[nodiscard]] std::int64_t read_user_units(const settings::YamlValue& value, Dimension dimension,
                                           const Unit& unit, const settings::IntegerLimits& limits);

/// @return the value that the configuration gives an object, the last one if there are several.
[[nodiscard]] std::optional<std::int64_t> given_value(const AxisConfiguration& axis, ObjectRow row);

/// @return the value of an object at power-up.
[[nodiscard]] std::int64_t value_at_start(const AxisConfiguration& axis, ObjectRow row);

/// @return turns of the load per turn of the motor: 3576h over 3577h.
[[nodiscard]] double gear_ratio_of(const AxisConfiguration& axis);

/// @return user units per revolution of the load [UU]. 4096 UU are one revolution of the shaft
///         whose encoder 6064h reads; with a single encoder that is the motor shaft, before the
///         gear.
[[nodiscard]] double user_units_per_load_turn(const AxisConfiguration& axis);

/// @return the highest velocity of 6064h that 6080h permits [UU/s].
[[nodiscard]] double highest_motor_velocity(const AxisConfiguration& axis);

/// @return a number with six significant digits, for display, such as "16.6667".
[[nodiscard]] std::string six_digits(double value);

}  // namespace vdrive::service
