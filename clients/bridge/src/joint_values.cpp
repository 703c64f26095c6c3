// SPDX-License-Identifier: Apache-2.0
#include "joint_values.hpp"

#include <numbers>

namespace vdrive::bridge {

JointValues joint_values(const AxisStatus& status, const JointScale& scale) {
  return {.position = status.load_position_actual_value * scale.si_per_user_unit,
          .velocity = status.load_velocity_actual_value * scale.si_per_user_unit,
          .effort = status.torque_actual_value * scale.effort_per_mille};
}

double si_per_user_unit(const Unit& unit) {
  const char* const si = unit.kind == UnitKind::rotary ? "rad" : "m";
  return 1.0 / user_units_in(unit, si).value_or(unit.size);
}

double effort_per_mille(const Unit& unit, const TorqueRating& rating) {
  // 1 ‰ of so many mN.m, at the motor [N.m].
  const double motor = static_cast<double>(rating.motor_rated_torque) * 1e-6;
  // A gear keeps the power, torque x speed. For `denominator` turns of the motor the load makes
  // `numerator`: the load has that much less speed and that much more torque.
  const double load = motor * static_cast<double>(rating.gear_ratio_denominator) /
                      static_cast<double>(rating.gear_ratio_numerator);
  // The same holds for the mechanism behind the load: for one turn, 2 pi rad, the axis moves by so
  // many rad or m. For an axis in the angle of the load both are 2 pi.
  const double way = kUserUnitsPerRevolution * si_per_user_unit(unit);
  return load * 2.0 * std::numbers::pi / way;
}

}  // namespace vdrive::bridge
