// SPDX-License-Identifier: Apache-2.0
#include "drive/vl_units.hpp"

#include "drive/registers.hpp"
#include "rounding.hpp"

#include <algorithm>
#include <cmath>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// The dictionary refuses 0, but a snapshot read from a file may hold any register value.
double factor_of(const Drive& drive, ObjectRow numerator, ObjectRow denominator) {
  const double over = real(drive, numerator);
  const double under = real(drive, denominator);
  return over == 0.0 || under == 0.0 ? 1.0 : over / under;
}

/// 604Ch.
double dimension_factor(const Drive& drive) {
  return factor_of(drive, "vl_dimension_factor_numerator"_object,
                   "vl_dimension_factor_denominator"_object);
}

/// Factor of 6042h, 6043h and 6044h.
double set_point_factor(const Drive& drive) {
  return dimension_factor(drive) * factor_of(drive, "vl_set_point_factor_numerator"_object,
                                             "vl_set_point_factor_denominator"_object);
}

/// An unsigned amount as a velocity [UU/s].
double velocity_of_amount(const Drive& drive, ObjectRow row) {
  return velocity_of_motor(drive, std::abs(dimension_factor(drive)) * real(drive, row));
}

/// A speed divided by a time, limited by `cap`.
double ramp_of(const Drive& drive, ObjectRow speed, ObjectRow seconds, ObjectRow cap) {
  const double ramp = velocity_of_amount(drive, speed) / std::max(real(drive, seconds), 1.0);
  return std::min(std::max(ramp, 1.0), std::max(real(drive, cap), 1.0));
}

/// A velocity of the motor in the units of 6042h.
std::int64_t in_vl_units(const Drive& drive, double rpm) {
  return wrapped(rounded16(rpm / set_point_factor(drive)));
}

}  // namespace

double vl_target(const Drive& drive) {
  const double target = real(drive, "vl_target_velocity"_object);
  return velocity_of_motor(drive, set_point_factor(drive) * target);
}

double limited_vl_target(const Drive& drive) {
  const double target = vl_target(drive);
  if (target == 0.0) return 0.0;
  const double lowest = velocity_of_amount(drive, "vl_velocity_min_amount"_object);
  const double highest = std::min(velocity_of_amount(drive, "vl_velocity_max_amount"_object),
                                  drive.registers().velocity_cap);
  const double speed = std::min(std::max(std::abs(target), lowest), highest);
  return target < 0.0 ? -speed : speed;
}

double vl_acceleration(const Drive& drive) {
  return ramp_of(drive, "vl_acceleration_delta_speed"_object, "vl_acceleration_delta_time"_object,
                 "app_acc_limit"_object);
}

double vl_deceleration(const Drive& drive) {
  return ramp_of(drive, "vl_deceleration_delta_speed"_object, "vl_deceleration_delta_time"_object,
                 "app_dec_limit"_object);
}

double vl_quick_stop_deceleration(const Drive& drive) {
  return ramp_of(drive, "vl_quick_stop_delta_speed"_object, "vl_quick_stop_delta_time"_object,
                 "app_dec_limit"_object);
}

std::int64_t vl_velocity_demand(const Drive& drive) {
  return in_vl_units(drive, demand_velocity(drive) / velocity_of_motor(drive, 1.0));
}

std::int64_t vl_velocity_actual_value(const Drive& drive) {
  if (shows_frozen_feedback(drive)) return 0;
  constexpr double kSecondsAMinute = 60.0;
  const double speed = drive.servo().motor_speed[drive.lane()];
  return in_vl_units(drive, speed * kSecondsAMinute / kUserUnitsPerRevolution);
}

}  // namespace vdrive
