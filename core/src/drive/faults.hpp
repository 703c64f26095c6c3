// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"
#include "vdrive/cia402/error_code.hpp"

#include <array>
#include <cstdint>

namespace vdrive {

// Faults of an axis: the causes present and the fault entered. The power stage implements the
// reaction.

/// A fault cause that is present as long as an input of the test bench is set.
struct FaultCause {
  std::uint8_t bit;  // in FaultState::causes
  ObjectRow input;
  ErrorCode code;
};

/// Loss of the DC link: a fault only if the motor is powered.
inline constexpr std::uint8_t kDcLinkCause = 1U << 3U;

/// In the order in which they are checked.
inline constexpr std::array<FaultCause, 4> kFaultCauses = [] {
  using namespace vdrive::literals;
  return std::array<FaultCause, 4>{{
      {1U << 0U, "test_over_current"_object, ErrorCode::continuous_over_current},
      {1U << 1U, "test_over_temperature"_object, ErrorCode::excess_temperature_drive},
      {1U << 2U, "test_encoder_failure"_object, ErrorCode::incremental_sensor_1_fault},
      {kDcLinkCause, "test_dc_link_loss"_object, ErrorCode::dc_link_under_voltage},
  }};
}();

/// The motor has become too hot (I2t), a cause without an input.
inline constexpr std::uint8_t kLoadLevelCause = 1U << 4U;

/// Motor heat relative to the steady state at rated current 6075h: a warning above the first value,
/// a fault from the second one on.
inline constexpr double kWarningHeat = 1.0;
inline constexpr double kFaultHeat = 1.1;

/// Updates the load level from the heat of the motor at the end of a tick.
/// @return whether the load level has changed.
bool note_heat(Drive& drive, double heat);

/// @return whether a cause persists, so that a fault reset is refused.
[[nodiscard]] bool cause_present(const Drive& drive);

/// Enters a fault into 603Fh, 1001h and 1003h.
void enter_fault(Drive& drive, ErrorCode code);

/// Fault reset: clears 603Fh and 1001h.
void clear_fault(Drive& drive);

/// Empties 1003h.
void clear_history(Drive& drive);

}  // namespace vdrive
