// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/power_state.hpp"

#include <cstdint>

namespace vdrive {

/// The transitions of CiA 402 caused by one event: a set of numbers from 0 to 16.
class TransitionSet {
 public:
  constexpr void add(unsigned number) noexcept { numbers_ |= 1U << number; }

  [[nodiscard]] constexpr bool contains(unsigned number) const noexcept {
    return (numbers_ >> number & 1U) != 0;
  }

  [[nodiscard]] constexpr bool empty() const noexcept { return numbers_ == 0; }

 private:
  std::uint32_t numbers_ = 0;
};

/// When Enable operation leads from Quick stop active to Operation enabled (transition 16, which
/// CiA 402-2 does not recommend).
enum class Transition16 : std::uint8_t {
  by_option_code,  ///< when 605Ah keeps the state after the stop (5 to 8)
  always,
  never,
};

/// The option codes and settings that the power state machine uses.
struct PowerOptions {
  std::int8_t quick_stop_option_code = 2;         ///< 605Ah, 0 to 8
  std::int8_t shutdown_option_code = 0;           ///< 605Bh, 0 or 1
  std::int8_t disable_operation_option_code = 1;  ///< 605Ch, 0 or 1
  bool enable_from_switch_on_disabled = true;     ///< 000Fh in Switch on disabled enables
  Transition16 transition_16 = Transition16::by_option_code;
};

/// Power state machine of CiA 402-2 with the manual's extension: one command leads from Switch on
/// disabled to Operation enabled.
///
/// A plain value: each function takes one event and returns the transitions that it caused; the
/// caller applies them to the axis. Where 605Bh or 605Ch asks for a ramp, transition 8 or 5 waits
/// in `pending` and the state stays Operation enabled until the ramp has ended.
class PowerStateMachine {
 public:
  [[nodiscard]] PowerState state() const noexcept { return state_; }

  /// @return the command whose ramp is still running: PowerCommand::shutdown (605Bh) or
  ///         PowerCommand::switch_on for Disable operation (605Ch), otherwise PowerCommand::none.
  ///         Enable operation does not cancel a ramp; Shutdown replaces Disable operation.
  [[nodiscard]] PowerCommand pending() const noexcept { return pending_; }

  /// Initialisation has finished: transition 1.
  TransitionSet initialised() noexcept;

  /// A controlword with `command` was written.
  /// @param voltage whether the DC link is present; without it the drive stays in Switch on
  ///        disabled
  /// @param cause_present whether the cause of a fault persists, in which case a reset is refused
  TransitionSet command(PowerCommand command, const PowerOptions& options, bool voltage,
                        bool cause_present) noexcept;

  /// A fault was detected: transition 13, unless a fault is already being handled.
  TransitionSet fault_detected() noexcept;

  /// The DC link was lost while the motor had no power, which is not a fault: back to Switch on
  /// disabled.
  TransitionSet voltage_lost() noexcept;

  /// The power stage dropped out, which is not a fault: transition 5, without a ramp.
  TransitionSet power_dropped() noexcept;

  /// The stop of the present state has finished: transition 14 of the fault reaction, 12 of a quick
  /// stop that does not stay in Quick stop active (605Ah 0 to 4), 5 or 8 of a pending ramp.
  TransitionSet stop_finished(const PowerOptions& options) noexcept;

 private:
  void take(unsigned number, TransitionSet& taken) noexcept;

  PowerState state_ = PowerState::not_ready_to_switch_on;
  PowerCommand pending_ = PowerCommand::none;
};

}  // namespace vdrive
