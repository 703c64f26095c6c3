// SPDX-License-Identifier: Apache-2.0
#include "joint_rating.hpp"

#include "joint_values.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <array>

namespace vdrive::bridge {

std::optional<double> read_effort_per_mille(const client::Axis& axis, const Unit& unit) {
  using namespace literals;
  constexpr std::array kObjects{kObjectRows["motor_rated_torque"_object].address,
                                kObjectRows["gear_ratio_numerator"_object].address,
                                kObjectRows["gear_ratio_denominator"_object].address};
  const auto readings = axis.read(kObjects);
  if (!readings) return std::nullopt;
  const auto& values = readings->objects;
  ensure(values.size() == kObjects.size(), "each object that is read has a reading");
  return effort_per_mille(unit, {.motor_rated_torque = values[0].value,
                                 .gear_ratio_numerator = values[1].value,
                                 .gear_ratio_denominator = values[2].value});
}

}  // namespace vdrive::bridge
