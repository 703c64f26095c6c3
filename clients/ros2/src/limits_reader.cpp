// SPDX-License-Identifier: Apache-2.0
#include "limits_reader.hpp"

#include "joint_values.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>

namespace vdrive::ros2 {
namespace {

using namespace vdrive::literals;

constexpr std::chrono::seconds kReadAgainAfter{2};

// What 607Ah can count to [UU].
constexpr double kLowestPosition = std::numeric_limits<std::int32_t>::min();
constexpr double kHighestPosition = std::numeric_limits<std::int32_t>::max();

constexpr std::array kLimitObjects{
    vdrive::describe("app_speed_limit"_object).address,
    vdrive::describe("motor_max_speed_rpm"_object).address,
    vdrive::describe("app_position_limit_switch"_object).address,
    vdrive::describe("user_position_lower_limit"_object).address,
    vdrive::describe("user_position_upper_limit"_object).address,
    vdrive::describe("app_acc_limit"_object).address,
    vdrive::describe("app_dec_limit"_object).address,
    vdrive::describe("profile_acc"_object).address,
    vdrive::describe("profile_dec"_object).address,
    vdrive::describe("max_torque"_object).address,
    vdrive::describe("motor_rated_torque"_object).address,
    vdrive::describe("gear_ratio_numerator"_object).address,
    vdrive::describe("gear_ratio_denominator"_object).address,
};

enum LimitObject : std::size_t {
  speed,
  motor_speed_rpm,
  limit_switch,
  lower,
  upper,
  acceleration,
  deceleration,
  profile_acceleration,
  profile_deceleration,
  max_torque,
  rated_torque,
  gear_numerator,
  gear_denominator,
};

std::optional<JointLimits> limits_of(const client::Axis& axis, const Joint& joint) {
  const auto readings = axis.read(kLimitObjects);
  if (!readings) return std::nullopt;
  const auto real = [&](LimitObject object) {
    return static_cast<double>(readings->objects[object].value);
  };
  const double unit = joint.si_per_user_unit;
  JointLimits limits;
  limits.velocity =
      std::min(real(speed), real(motor_speed_rpm) * kUserUnitsPerRevolution / 60.0) * unit;
  limits.acceleration = real(acceleration) * unit;
  limits.deceleration = real(deceleration) * unit;
  limits.ramp = std::min({real(profile_acceleration) * unit, real(profile_deceleration) * unit,
                          limits.acceleration, limits.deceleration});
  const bool has_limits = real(limit_switch) != 0.0 && real(lower) < real(upper);
  limits.lower = (has_limits ? real(lower) : kLowestPosition) * unit;
  limits.upper = (has_limits ? real(upper) : kHighestPosition) * unit;
  limits.effort_per_mille = bridge::effort_per_mille(
      joint.unit, {.motor_rated_torque = readings->objects[rated_torque].value,
                   .gear_ratio_numerator = readings->objects[gear_numerator].value,
                   .gear_ratio_denominator = readings->objects[gear_denominator].value});
  limits.effort = real(max_torque) * limits.effort_per_mille;
  return limits;
}

}  // namespace

LimitsReader::Limits LimitsReader::limits() const {
  const std::scoped_lock lock(mutex_);
  return limits_;
}

bool LimitsReader::read(const std::vector<client::Axis>& axes, const std::vector<Joint>& joints,
                        Clock::time_point now) {
  const std::uint64_t requested = requested_;
  due_ = now + kReadAgainAfter;
  auto limits = std::make_shared<std::vector<JointLimits>>();
  limits->reserve(axes.size());
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto read = limits_of(axes[i], joints[i]);
    if (!read) return false;
    limits->push_back(*read);
  }
  {
    const std::scoped_lock lock(mutex_);
    limits_ = std::move(limits);
  }
  read_ = requested;  // after the limits: who waits for this number takes them
  return true;
}

}  // namespace vdrive::ros2
