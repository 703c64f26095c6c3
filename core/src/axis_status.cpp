// SPDX-License-Identifier: Apache-2.0
#include "vdrive/axis_status.hpp"

#include <algorithm>
#include <array>

namespace vdrive {
namespace {

using namespace vdrive::literals;

template <auto kMember>
std::int64_t get(const AxisStatus& status) noexcept {
  return status.*kMember;
}

struct Member {
  ObjectRow row;
  std::int64_t (*value)(const AxisStatus&) noexcept;
};

constexpr std::array<Member, 20> kMembers{{
    {"error_register"_object, get<&AxisStatus::error_register>},
    {"motor_op_status"_object, get<&AxisStatus::motor_op_status>},
    {"load_velocity_error_value"_object, get<&AxisStatus::load_velocity_error_value>},
    {"current_error_value"_object, get<&AxisStatus::current_error_value>},
    {"motor_position_actual_value"_object, get<&AxisStatus::motor_position_actual_value>},
    {"motor_position_error_value"_object, get<&AxisStatus::motor_position_error_value>},
    {"motor_velocity_actual_value"_object, get<&AxisStatus::motor_velocity_actual_value>},
    {"motor_velocity_error_value"_object, get<&AxisStatus::motor_velocity_error_value>},
    {"error_code"_object, get<&AxisStatus::error_code>},
    {"ds402_statusword"_object, get<&AxisStatus::ds402_statusword>},
    {"op_mode_actual"_object, get<&AxisStatus::op_mode_actual>},
    {"position_demand_value"_object, get<&AxisStatus::position_demand_value>},
    {"load_position_actual_value"_object, get<&AxisStatus::load_position_actual_value>},
    {"velocity_demand_value"_object, get<&AxisStatus::velocity_demand_value>},
    {"load_velocity_actual_value"_object, get<&AxisStatus::load_velocity_actual_value>},
    {"torque_demand"_object, get<&AxisStatus::torque_demand>},
    {"torque_actual_value"_object, get<&AxisStatus::torque_actual_value>},
    {"current_actual_value"_object, get<&AxisStatus::current_actual_value>},
    {"load_position_error_value"_object, get<&AxisStatus::load_position_error_value>},
    {"digital_inputs"_object, get<&AxisStatus::digital_inputs>},
}};

}  // namespace

std::optional<std::int64_t> value_of(const AxisStatus& status, ObjectRow row) noexcept {
  const auto* const member = std::find_if(kMembers.begin(), kMembers.end(), [row](const Member& m) {
    return m.row == row;
  });
  if (member == kMembers.end()) {
    return std::nullopt;
  }
  return member->value(status);
}

}  // namespace vdrive
