// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace vdrive {

/// States of the power drive system (CiA 402-2, power state machine).
enum class PowerState : std::uint8_t {
  not_ready_to_switch_on,
  switch_on_disabled,
  ready_to_switch_on,
  switched_on,
  operation_enabled,
  quick_stop_active,
  fault_reaction_active,
  fault,
};

/// @return whether the drive has a fault and either reacts to it (Fault reaction active) or waits
///         for a reset (Fault).
[[nodiscard]] constexpr bool is_fault(PowerState state) noexcept {
  return state == PowerState::fault_reaction_active || state == PowerState::fault;
}

/// @return the standard's name of `state`, such as "Operation enabled".
[[nodiscard]] std::string_view to_string(PowerState state) noexcept;

/// @return the state shown by a statusword 6041h (masks 004Fh and 006Fh of CiA 402);
///         not_ready_to_switch_on for a word that matches no mask.
[[nodiscard]] PowerState decode_power_state(std::uint16_t statusword) noexcept;

}  // namespace vdrive
