// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive {

/// Bits of the controlword 6040h (CiA 402; manual, table of the controlword).
struct Controlword {
  static constexpr std::uint16_t kSwitchOn = 1U << 0U;
  static constexpr std::uint16_t kEnableVoltage = 1U << 1U;
  static constexpr std::uint16_t kQuickStop = 1U << 2U;  ///< 0 = quick stop
  static constexpr std::uint16_t kEnableOperation = 1U << 3U;
  static constexpr std::uint16_t kNewSetPoint = 1U << 4U;           ///< profile position
  static constexpr std::uint16_t kStartHoming = 1U << 4U;           ///< homing
  static constexpr std::uint16_t kEnableInterpolation = 1U << 4U;   ///< interpolated position
  static constexpr std::uint16_t kChangeSetImmediately = 1U << 5U;  ///< profile position
  static constexpr std::uint16_t kRelative = 1U << 6U;              ///< profile position
  static constexpr std::uint16_t kEnableRamp = 1U << 4U;            ///< velocity (vl)
  static constexpr std::uint16_t kUnlockRamp = 1U << 5U;            ///< velocity (vl)
  static constexpr std::uint16_t kReferenceRamp = 1U << 6U;         ///< velocity (vl)
  static constexpr std::uint16_t kFaultReset = 1U << 7U;
  static constexpr std::uint16_t kHalt = 1U << 8U;
};

/// Controlwords that carry exactly one command of the power state machine (CiA 402, command
/// coding).
namespace controlwords {
inline constexpr std::uint16_t kDisableVoltage = 0;
inline constexpr std::uint16_t kQuickStop = Controlword::kEnableVoltage;
inline constexpr std::uint16_t kShutdown = kQuickStop | Controlword::kQuickStop;
inline constexpr std::uint16_t kSwitchOn = kShutdown | Controlword::kSwitchOn;
inline constexpr std::uint16_t kDisableOperation = kSwitchOn;  ///< in Operation enabled
inline constexpr std::uint16_t kEnableOperation = kSwitchOn | Controlword::kEnableOperation;
}  // namespace controlwords

/// The command in bits 0 to 3 and 7 of a controlword (CiA 402, command coding).
enum class PowerCommand : std::uint8_t {
  none,
  disable_voltage,
  quick_stop,
  shutdown,
  switch_on,  ///< Switch on; in Operation enabled the same pattern is Disable operation
  enable_operation,
  fault_reset,
};

/// Decodes one written controlword. While bit 7 is 1, a word carries no command other than the
/// reset, and only the rising edge of bit 7 resets.
/// @param previous_word the controlword in force before this one
[[nodiscard]] PowerCommand decode_command(std::uint16_t word, std::uint16_t previous_word) noexcept;

}  // namespace vdrive
