// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/power_state.hpp"

#include <array>
#include <cstdint>
#include <span>

namespace vdrive {

/// The full sequence, from Quick stop active. Other states start later in the sequence.
inline constexpr std::array kEnablingWords{controlwords::kDisableVoltage, controlwords::kShutdown,
                                           controlwords::kSwitchOn, controlwords::kEnableOperation};

/// @return the controlwords that lead from a power state without a fault to Operation enabled (CiA
///         402, transitions 2 to 4), to be written one after the other; none in Operation enabled.
///         From Quick stop active the first word removes the power (transition 12), which every
///         value of 605Ah allows.
[[nodiscard]] constexpr std::span<const std::uint16_t> enabling_words(PowerState state) noexcept {
  const std::span<const std::uint16_t> all(kEnablingWords);
  switch (state) {
    case PowerState::operation_enabled:
      return {};
    case PowerState::switched_on:
      return all.last(1);
    case PowerState::ready_to_switch_on:
      return all.last(2);
    case PowerState::quick_stop_active:
      return all;
    default:
      return all.last(3);
  }
}

}  // namespace vdrive
