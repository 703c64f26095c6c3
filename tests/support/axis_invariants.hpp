// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
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
  static constexpr const char* kModeBits = "bits 10 and 12 of 6041h are those of state and mode";
};

/// @return which of bits 10 and 12 of 6041h an axis may show in `state` and with the mode of 6061h.
[[nodiscard]] inline std::uint16_t possible_mode_bits(PowerState state, std::int8_t mode) {
  constexpr std::uint16_t kBit12 = Statusword::kSetPointAcknowledge;
  if (state == PowerState::quick_stop_active) return Statusword::kTargetReached;
  const OperatingModeRow* const row = find_operating_mode(static_cast<OperatingMode>(mode));
  if (state != PowerState::operation_enabled || row == nullptr) return 0;
  const bool has_bit_12 =
      std::ranges::find(row->status_bits, kBit12, &BitName::bit) != row->status_bits.end();
  // 5E20h:0A shows bit 10 in a mode without a target.
  const bool has_bit_10 =
      row->has_target || row->mode == OperatingMode::cyclic_synchronous_position;
  return static_cast<std::uint16_t>((has_bit_12 ? kBit12 : 0U) |
                                    (has_bit_10 ? Statusword::kTargetReached : 0U));
}

/// @return the first of StatusInvariant that `status` violates, or nullptr.
/// @param expected the state in which the axis is
/// @param maker_bits of 6041h that the axis shows the other way round, 5E20h:0C
[[nodiscard]] inline const char* violated_invariant(const AxisStatus& status, PowerState expected,
                                                    std::int64_t maker_bits = 0) {
  constexpr std::uint16_t kReservedBits = 0xC100;
  constexpr std::uint16_t kModeBits = Statusword::kTargetReached | Statusword::kSetPointAcknowledge;
  const PowerState state = decode_power_state(status.ds402_statusword);
  const bool in_fault = state == PowerState::fault || state == PowerState::fault_reaction_active;
  const bool may_be_powered = state == PowerState::operation_enabled ||
                              state == PowerState::quick_stop_active ||
                              state == PowerState::fault_reaction_active;
  if (state != expected) return StatusInvariant::kState;
  if ((status.ds402_statusword & kReservedBits & ~maker_bits) != 0) {
    return StatusInvariant::kReserved;
  }
  const std::uint16_t possible = possible_mode_bits(state, status.op_mode_actual);
  if ((status.ds402_statusword & kModeBits & ~possible) != 0) return StatusInvariant::kModeBits;
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
