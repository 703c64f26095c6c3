// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"

namespace vdrive::wire {

/// Calls `visit(member, in_message)` for each member of AxisStatus that is on the network, in the
/// order of the IDL, behind `last_sequence`. `in_message(message)` is that member of a
/// msg::AxisStatus: its value, or where the message can be written a reference to it.
template <typename Visit>
constexpr void for_each_status_member(const Visit& visit) {
  visit(&AxisStatus::ds402_statusword, [](auto& message) -> decltype(auto) {
    return message.ds402_statusword();
  });
  visit(&AxisStatus::op_mode_actual, [](auto& message) -> decltype(auto) {
    return message.op_mode_actual();
  });
  visit(&AxisStatus::motor_op_status, [](auto& message) -> decltype(auto) {
    return message.motor_op_status();
  });
  visit(&AxisStatus::error_code, [](auto& message) -> decltype(auto) {
    return message.error_code();
  });
  visit(&AxisStatus::error_register, [](auto& message) -> decltype(auto) {
    return message.error_register();
  });
  visit(&AxisStatus::digital_inputs, [](auto& message) -> decltype(auto) {
    return message.digital_inputs();
  });
  visit(&AxisStatus::position_demand_value, [](auto& message) -> decltype(auto) {
    return message.position_demand_value();
  });
  visit(&AxisStatus::load_position_actual_value, [](auto& message) -> decltype(auto) {
    return message.load_position_actual_value();
  });
  visit(&AxisStatus::load_position_error_value, [](auto& message) -> decltype(auto) {
    return message.load_position_error_value();
  });
  visit(&AxisStatus::motor_position_actual_value, [](auto& message) -> decltype(auto) {
    return message.motor_position_actual_value();
  });
  visit(&AxisStatus::motor_position_error_value, [](auto& message) -> decltype(auto) {
    return message.motor_position_error_value();
  });
  visit(&AxisStatus::velocity_demand_value, [](auto& message) -> decltype(auto) {
    return message.velocity_demand_value();
  });
  visit(&AxisStatus::load_velocity_actual_value, [](auto& message) -> decltype(auto) {
    return message.load_velocity_actual_value();
  });
  visit(&AxisStatus::load_velocity_error_value, [](auto& message) -> decltype(auto) {
    return message.load_velocity_error_value();
  });
  visit(&AxisStatus::motor_velocity_actual_value, [](auto& message) -> decltype(auto) {
    return message.motor_velocity_actual_value();
  });
  visit(&AxisStatus::motor_velocity_error_value, [](auto& message) -> decltype(auto) {
    return message.motor_velocity_error_value();
  });
  visit(&AxisStatus::current_actual_value, [](auto& message) -> decltype(auto) {
    return message.current_actual_value();
  });
  visit(&AxisStatus::current_error_value, [](auto& message) -> decltype(auto) {
    return message.current_error_value();
  });
  visit(&AxisStatus::torque_demand, [](auto& message) -> decltype(auto) {
    return message.torque_demand();
  });
  visit(&AxisStatus::torque_actual_value, [](auto& message) -> decltype(auto) {
    return message.torque_actual_value();
  });
  visit(&AxisStatus::ignored_set_points, [](auto& message) -> decltype(auto) {
    return message.ignored_set_points();
  });
  visit(&AxisStatus::fault_count, [](auto& message) -> decltype(auto) {
    return message.fault_count();
  });
}

}  // namespace vdrive::wire
