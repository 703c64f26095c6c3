// SPDX-License-Identifier: Apache-2.0
#include "joint_limits.hpp"

#include "joint_values.hpp"
#include "joints.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace vdrive::ros2 {
namespace {

using namespace vdrive::literals;

// The range of 607Ah [UU].
constexpr double kLowestPosition = std::numeric_limits<std::int32_t>::min();
constexpr double kHighestPosition = std::numeric_limits<std::int32_t>::max();

constexpr std::array kLimitObjects{"app_speed_limit"_object,
                                   "motor_speed_limit"_object,
                                   "app_position_limit_switch"_object,
                                   "user_position_lower_limit"_object,
                                   "user_position_upper_limit"_object,
                                   "min_position_range_limit"_object,
                                   "max_position_range_limit"_object,
                                   "app_acc_limit"_object,
                                   "app_dec_limit"_object,
                                   "profile_acc"_object,
                                   "profile_dec"_object,
                                   "max_torque"_object,
                                   "torque_slope"_object,
                                   "motor_rated_torque"_object,
                                   "gear_ratio_numerator"_object,
                                   "gear_ratio_denominator"_object};

std::optional<JointLimits> limits_of(const client::Axis& axis, const ServedJoint& joint) {
  std::array<ObjectAddress, kLimitObjects.size()> addresses{};
  std::ranges::transform(kLimitObjects, addresses.begin(), [](ObjectRow row) {
    return vdrive::describe(row).address;
  });
  const auto readings = axis.read(addresses);
  if (!readings) return std::nullopt;
  const auto value = [&](ObjectRow row) {
    const auto* const found = std::ranges::find(kLimitObjects, row);
    ensure(found != kLimitObjects.end(), "an object that is used is read");
    return readings->objects[static_cast<std::size_t>(found - kLimitObjects.begin())].value;
  };
  const auto real = [&](ObjectRow row) {
    return static_cast<double>(value(row));
  };
  const double unit = joint.si_per_user_unit;
  JointLimits limits;
  limits.velocity =
      std::min(real("app_speed_limit"_object), real("motor_speed_limit"_object)) * unit;
  limits.acceleration = real("app_acc_limit"_object) * unit;
  limits.deceleration = real("app_dec_limit"_object) * unit;
  limits.ramp = std::min({real("profile_acc"_object) * unit, real("profile_dec"_object) * unit,
                          limits.acceleration, limits.deceleration});
  const double lower = real("user_position_lower_limit"_object);
  const double upper = real("user_position_upper_limit"_object);
  const bool has_limits = real("app_position_limit_switch"_object) != 0.0 && lower < upper;
  // On a modulo axis, 6062h stays within the range: with a goal beyond it, the bridge would never
  // see the axis arrive.
  const double first = real("min_position_range_limit"_object);
  const double end = real("max_position_range_limit"_object);
  const bool has_range = first < end;
  limits.lower =
      std::max(has_limits ? lower : kLowestPosition, has_range ? first : kLowestPosition) * unit;
  limits.upper =
      std::min(has_limits ? upper : kHighestPosition, has_range ? end - 1.0 : kHighestPosition) *
      unit;
  limits.effort_per_mille = bridge::effort_per_mille(
      joint.unit, {.motor_rated_torque = value("motor_rated_torque"_object),
                   .gear_ratio_numerator = value("gear_ratio_numerator"_object),
                   .gear_ratio_denominator = value("gear_ratio_denominator"_object)});
  limits.effort = real("max_torque"_object) * limits.effort_per_mille;
  limits.effort_slope = real("torque_slope"_object) * limits.effort_per_mille;
  return limits;
}

}  // namespace

std::optional<std::vector<JointLimits>> read_limits(std::span<const client::Axis> axes,
                                                    std::span<const ServedJoint> joints) {
  ensure(axes.size() == joints.size(), "each joint has its axis");
  std::vector<JointLimits> limits;
  limits.reserve(axes.size());
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto read = limits_of(axes[i], joints[i]);
    if (!read) return std::nullopt;
    limits.push_back(*read);
  }
  return limits;
}

}  // namespace vdrive::ros2
