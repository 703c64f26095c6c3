// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string_view>
#include <type_traits>

namespace vdrive {

template <auto kMember>
std::int64_t get_status_member(const AxisStatus& status) noexcept {
  return status.*kMember;
}

template <auto kMember>
void set_status_member(AxisStatus& status, std::int64_t value) noexcept {
  status.*kMember = static_cast<std::remove_reference_t<decltype(status.*kMember)>>(value);
}

template <typename Number>
constexpr DataType data_type_of() noexcept {
  constexpr bool kIsSigned = std::is_signed_v<Number>;
  switch (sizeof(Number)) {
    case 1:
      return kIsSigned ? DataType::integer8 : DataType::unsigned8;
    case 2:
      return kIsSigned ? DataType::integer16 : DataType::unsigned16;
    default:
      static_assert(sizeof(Number) <= 4, "the dictionary has no longer type");
      return kIsSigned ? DataType::integer32 : DataType::unsigned32;
  }
}

template <auto kMember>
constexpr StatusMember status_member(std::string_view name, bool is_published = true) {
  const auto row = find_row(name);
  return {.name = name,
          .address = row ? kObjectRows[*row].address : ObjectAddress{},
          .data_type = data_type_of<std::remove_cvref_t<decltype(AxisStatus{}.*kMember)>>(),
          .is_published = is_published,
          .value = get_status_member<kMember>,
          .set = set_status_member<kMember>};
}

/// Every member of AxisStatus once, in the order of their declaration: the order of the check
/// values of a journal.
inline constexpr std::array<StatusMember, kStatusMembers> kStatusMemberTable{{
    status_member<&AxisStatus::position_demand_value>("position_demand_value"),
    status_member<&AxisStatus::load_position_actual_value>("load_position_actual_value"),
    status_member<&AxisStatus::load_position_error_value>("load_position_error_value"),
    status_member<&AxisStatus::motor_position_actual_value>("motor_position_actual_value"),
    status_member<&AxisStatus::motor_position_error_value>("motor_position_error_value"),
    status_member<&AxisStatus::velocity_demand_value>("velocity_demand_value"),
    status_member<&AxisStatus::load_velocity_actual_value>("load_velocity_actual_value"),
    status_member<&AxisStatus::load_velocity_error_value>("load_velocity_error_value"),
    status_member<&AxisStatus::motor_velocity_actual_value>("motor_velocity_actual_value"),
    status_member<&AxisStatus::motor_velocity_error_value>("motor_velocity_error_value"),
    status_member<&AxisStatus::current_error_value>("current_error_value"),
    status_member<&AxisStatus::current_actual_value>("current_actual_value"),
    status_member<&AxisStatus::torque_actual_value>("torque_actual_value"),
    status_member<&AxisStatus::torque_demand>("torque_demand"),
    status_member<&AxisStatus::ds402_statusword>("ds402_statusword"),
    status_member<&AxisStatus::ds402_controlword>("ds402_controlword", false),
    status_member<&AxisStatus::error_code>("error_code"),
    status_member<&AxisStatus::op_mode_actual>("op_mode_actual"),
    status_member<&AxisStatus::motor_op_status>("motor_op_status"),
    status_member<&AxisStatus::error_register>("error_register"),
    status_member<&AxisStatus::digital_inputs>("digital_inputs"),
    status_member<&AxisStatus::ignored_set_points>("ignored_set_points"),
    status_member<&AxisStatus::fault_count>("fault_count"),
}};

static_assert(std::accumulate(kStatusMemberTable.begin(), kStatusMemberTable.end(), std::size_t{0},
                              [](std::size_t bytes, const StatusMember& member) {
                                return bytes + size_of(member.data_type);
                              }) == sizeof(AxisStatus),
              "each member of AxisStatus has one row, and no gap before it");

}  // namespace vdrive
