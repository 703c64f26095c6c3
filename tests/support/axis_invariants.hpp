// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <cstdint>

namespace vdrive::test {

/// The invariants of the status image of any axis in any tick, without its history.
struct StatusInvariant {
  static constexpr const char* kState = "6041h decodes to the power state";
  static constexpr const char* kReserved = "reserved bits of 6041h are 0";
  static constexpr const char* kPower = "no power outside its states";
  static constexpr const char* kTorque = "no torque without power";
  static constexpr const char* kDemand = "606Bh is 0 without power";
  static constexpr const char* kErrorCode = "603Fh is set in a fault only";
};

/// @return the first of StatusInvariant that `status` violates, or nullptr.
/// @param expected the state in which the axis is
[[nodiscard]] inline const char* violated_invariant(const AxisStatus& status, PowerState expected) {
  constexpr std::uint16_t kReservedBits = 0xC100;
  const PowerState state = decode_power_state(status.ds402_statusword);
  const bool in_fault = state == PowerState::fault || state == PowerState::fault_reaction_active;
  const bool may_be_powered = state == PowerState::operation_enabled ||
                              state == PowerState::quick_stop_active ||
                              state == PowerState::fault_reaction_active;
  if (state != expected) return StatusInvariant::kState;
  if ((status.ds402_statusword & kReservedBits) != 0) return StatusInvariant::kReserved;
  if (status.motor_op_status != 0 && !may_be_powered) return StatusInvariant::kPower;
  if (status.motor_op_status != 1 && status.torque_actual_value != 0) {
    return StatusInvariant::kTorque;
  }
  if (status.motor_op_status != 1 && status.velocity_demand_value != 0) {
    return StatusInvariant::kDemand;
  }
  return (status.error_code != 0) != in_fault ? StatusInvariant::kErrorCode : nullptr;
}

}  // namespace vdrive::test
