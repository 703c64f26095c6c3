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

/// Values of an axis in its user units, as a configuration gives them.

/// Ratios of sizes of units that differ from 1 by less are 1: sizes are written in decimals.
inline constexpr double kSameSize = 1.0e-6;

/// @return [UU] a whole number of user units, or a value with a unit of the axis, rounded to the
///         nearest: 4096, 25mm, 250mm/s.
/// @throws ConfigurationError for anything else, a unit that the axis does not have, and a value
///         outside the limits.
[[nodiscard]] std::int64_t read_user_units(const settings::YamlValue& value, Dimension dimension,
                                           const Unit& unit, const settings::IntegerLimits& limits);

/// @return the value that the configuration gives to an object, the last one if there are several.
[[nodiscard]] std::optional<std::int64_t> given_value(const AxisConfiguration& axis, ObjectRow row);

/// @return the value that an object has from power-up on.
[[nodiscard]] std::int64_t value_at_start(const AxisConfiguration& axis, ObjectRow row);

/// @return turns of the load for one of the motor: 3576h over 3577h.
[[nodiscard]] double gear_ratio_of(const AxisConfiguration& axis);

/// @return [UU] of a revolution of the load. 4096 are a revolution of the shaft whose encoder 6064h
///         reads: with one encoder the motor's, which the gear divides.
[[nodiscard]] double user_units_a_load_turn(const AxisConfiguration& axis);

/// @return the highest velocity of 6064h that 6080h permits [UU/s].
[[nodiscard]] double highest_motor_velocity(const AxisConfiguration& axis);

/// @return a number with as many digits as people read, such as "16.6667".
[[nodiscard]] std::string six_digits(double value);

}  // namespace vdrive::service
