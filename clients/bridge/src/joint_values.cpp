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
  // 1 ‰ of a torque in mN.m, at the motor [N.m].
  const double motor = static_cast<double>(rating.motor_rated_torque) * 1e-6;
  // A gear preserves the power, torque x speed. While the motor makes `denominator` turns, the load
  // makes `numerator`: its speed is that much lower and its torque that much higher.
  const double load = motor * static_cast<double>(rating.gear_ratio_denominator) /
                      static_cast<double>(rating.gear_ratio_numerator);
  // The same holds for the mechanism after the load: for one turn, 2 pi rad, the axis moves by
  // `way` rad or m. If the axis is the angle of the load, both are 2 pi.
  const double way = kUserUnitsPerRevolution * si_per_user_unit(unit);
  return load * 2.0 * std::numbers::pi / way;
}

}  // namespace vdrive::bridge
