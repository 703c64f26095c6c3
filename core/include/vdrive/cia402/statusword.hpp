// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/power_state.hpp"

#include <cstdint>

namespace vdrive {

/// Bits of the statusword 6041h (CiA 402; manual, table of the statusword).
struct Statusword {
  static constexpr std::uint16_t kReadyToSwitchOn = 1U << 0U;
  static constexpr std::uint16_t kSwitchedOn = 1U << 1U;
  static constexpr std::uint16_t kOperationEnabled = 1U << 2U;
  static constexpr std::uint16_t kFault = 1U << 3U;
  static constexpr std::uint16_t kVoltageEnabled = 1U << 4U;
  static constexpr std::uint16_t kQuickStop = 1U << 5U;  ///< 0 = quick stop in progress
  static constexpr std::uint16_t kSwitchOnDisabled = 1U << 6U;
  static constexpr std::uint16_t kWarning = 1U << 7U;
  static constexpr std::uint16_t kRemote = 1U << 9U;
  static constexpr std::uint16_t kTargetReached = 1U << 10U;
  static constexpr std::uint16_t kInternalLimitActive = 1U << 11U;
  static constexpr std::uint16_t kSetPointAcknowledge = 1U << 12U;  ///< profile position
  static constexpr std::uint16_t kSpeedZero = 1U << 12U;            ///< profile velocity
  static constexpr std::uint16_t kHomingAttained = 1U << 12U;       ///< homing
  static constexpr std::uint16_t kInterpolationActive = 1U << 12U;  ///< interpolated position
  static constexpr std::uint16_t kFollowsCommand = 1U << 12U;       ///< cyclic modes
  static constexpr std::uint16_t kFollowingError = 1U << 13U;       ///< with closed position loop
  static constexpr std::uint16_t kHomingError = 1U << 13U;          ///< homing
  static constexpr std::uint16_t kState =
      kReadyToSwitchOn | kSwitchedOn | kOperationEnabled | kFault | kQuickStop | kSwitchOnDisabled;
};

/// @return bits 0, 1, 2, 3, 5 and 6 for `state`. Bit 5 is 1 only in Ready to switch on, Switched on
///         and Operation enabled: it follows the state, not controlword bit 2.
[[nodiscard]] std::uint16_t statusword_of(PowerState state) noexcept;

}  // namespace vdrive
