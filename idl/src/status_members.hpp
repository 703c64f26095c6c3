// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"

#include <tuple>

namespace vdrive::wire {

/// A member of AxisStatus that is on the network. `in_message(message)` is that member of a
/// msg::AxisStatus: its value, or where the message can be written a reference to it.
template <typename Member, typename InMessage>
struct WireStatusMember {
  Member member;
  InMessage in_message;
};

template <typename Member, typename InMessage>
WireStatusMember(Member, InMessage) -> WireStatusMember<Member, InMessage>;

/// All of them, in the order of the IDL, behind `last_sequence`.
inline constexpr std::tuple kWireStatusMembers{
    WireStatusMember{&AxisStatus::ds402_statusword,
                     [](auto& message) -> decltype(auto) {
                       return message.ds402_statusword();
                     }},
    WireStatusMember{&AxisStatus::op_mode_actual,
                     [](auto& message) -> decltype(auto) {
                       return message.op_mode_actual();
                     }},
    WireStatusMember{&AxisStatus::motor_op_status,
                     [](auto& message) -> decltype(auto) {
                       return message.motor_op_status();
                     }},
    WireStatusMember{&AxisStatus::error_code,
                     [](auto& message) -> decltype(auto) {
                       return message.error_code();
                     }},
    WireStatusMember{&AxisStatus::error_register,
                     [](auto& message) -> decltype(auto) {
                       return message.error_register();
                     }},
    WireStatusMember{&AxisStatus::digital_inputs,
                     [](auto& message) -> decltype(auto) {
                       return message.digital_inputs();
                     }},
    WireStatusMember{&AxisStatus::position_demand_value,
                     [](auto& message) -> decltype(auto) {
                       return message.position_demand_value();
                     }},
    WireStatusMember{&AxisStatus::load_position_actual_value,
                     [](auto& message) -> decltype(auto) {
                       return message.load_position_actual_value();
                     }},
    WireStatusMember{&AxisStatus::load_position_error_value,
                     [](auto& message) -> decltype(auto) {
                       return message.load_position_error_value();
                     }},
    WireStatusMember{&AxisStatus::motor_position_actual_value,
                     [](auto& message) -> decltype(auto) {
                       return message.motor_position_actual_value();
                     }},
    WireStatusMember{&AxisStatus::motor_position_error_value,
                     [](auto& message) -> decltype(auto) {
                       return message.motor_position_error_value();
                     }},
    WireStatusMember{&AxisStatus::velocity_demand_value,
                     [](auto& message) -> decltype(auto) {
                       return message.velocity_demand_value();
                     }},
    WireStatusMember{&AxisStatus::load_velocity_actual_value,
                     [](auto& message) -> decltype(auto) {
                       return message.load_velocity_actual_value();
                     }},
    WireStatusMember{&AxisStatus::load_velocity_error_value,
                     [](auto& message) -> decltype(auto) {
                       return message.load_velocity_error_value();
                     }},
    WireStatusMember{&AxisStatus::motor_velocity_actual_value,
                     [](auto& message) -> decltype(auto) {
                       return message.motor_velocity_actual_value();
                     }},
    WireStatusMember{&AxisStatus::motor_velocity_error_value,
                     [](auto& message) -> decltype(auto) {
                       return message.motor_velocity_error_value();
                     }},
    WireStatusMember{&AxisStatus::current_actual_value,
                     [](auto& message) -> decltype(auto) {
                       return message.current_actual_value();
                     }},
    WireStatusMember{&AxisStatus::current_error_value,
                     [](auto& message) -> decltype(auto) {
                       return message.current_error_value();
                     }},
    WireStatusMember{&AxisStatus::torque_demand,
                     [](auto& message) -> decltype(auto) {
                       return message.torque_demand();
                     }},
    WireStatusMember{&AxisStatus::torque_actual_value,
                     [](auto& message) -> decltype(auto) {
                       return message.torque_actual_value();
                     }},
    WireStatusMember{&AxisStatus::ignored_set_points,
                     [](auto& message) -> decltype(auto) {
                       return message.ignored_set_points();
                     }},
    WireStatusMember{&AxisStatus::fault_count, [](auto& message) -> decltype(auto) {
                       return message.fault_count();
                     }}};

/// Calls `visit(member, in_message)` for each of them in their order.
template <typename Visit>
constexpr void for_each_status_member(const Visit& visit) {
  std::apply(
      [&](const auto&... members) {
        (visit(members.member, members.in_message), ...);
      },
      kWireStatusMembers);
}

}  // namespace vdrive::wire
