// SPDX-License-Identifier: Apache-2.0
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <array>

namespace vdrive {
namespace {

struct StateRow {
  PowerState state;
  std::uint16_t mask;
  std::uint16_t value;        // of the masked statusword
  std::uint16_t status_bits;  // as the drive shows them; see statusword_of
  std::string_view name;
};

// Manual, table of statusword bits 0 to 3, 5 and 6; masks as in CiA 402.
constexpr std::array<StateRow, 8> kStates{{
    {PowerState::not_ready_to_switch_on, 0x4F, 0x00, 0x00, "Not ready to switch on"},
    {PowerState::switch_on_disabled, 0x4F, 0x40, 0x40, "Switch on disabled"},
    {PowerState::ready_to_switch_on, 0x6F, 0x21, 0x21, "Ready to switch on"},
    {PowerState::switched_on, 0x6F, 0x23, 0x23, "Switched on"},
    {PowerState::operation_enabled, 0x6F, 0x27, 0x27, "Operation enabled"},
    {PowerState::quick_stop_active, 0x6F, 0x07, 0x07, "Quick stop active"},
    {PowerState::fault_reaction_active, 0x4F, 0x0F, 0x0F, "Fault reaction active"},
    {PowerState::fault, 0x4F, 0x08, 0x08, "Fault"},
}};

constexpr bool rows_follow_the_enumeration() {
  for (std::size_t i = 0; i < kStates.size(); ++i) {
    if (static_cast<std::size_t>(kStates[i].state) != i) return false;
  }
  return true;
}

static_assert(rows_follow_the_enumeration(), "rows are indexed by the state");

}  // namespace

std::string_view to_string(PowerState state) noexcept {
  return kStates[static_cast<std::size_t>(state)].name;
}

PowerState decode_power_state(std::uint16_t statusword) noexcept {
  for (const StateRow& row : kStates) {
    if ((statusword & row.mask) == row.value) return row.state;
  }
  return PowerState::not_ready_to_switch_on;
}

std::uint16_t statusword_of(PowerState state) noexcept {
  return kStates[static_cast<std::size_t>(state)].status_bits;
}

std::string_view to_string(OperatingMode mode) noexcept {
  const OperatingModeRow* const row = find_operating_mode(mode);
  return row == nullptr ? "unknown" : row->name;
}

PowerCommand decode_command(std::uint16_t word, std::uint16_t previous_word) noexcept {
  if ((word & Controlword::kFaultReset) != 0) {
    const bool rising = (previous_word & Controlword::kFaultReset) == 0;
    return rising ? PowerCommand::fault_reset : PowerCommand::none;
  }
  if ((word & Controlword::kEnableVoltage) == 0) return PowerCommand::disable_voltage;
  if ((word & Controlword::kQuickStop) == 0) return PowerCommand::quick_stop;
  if ((word & Controlword::kSwitchOn) == 0) return PowerCommand::shutdown;
  return (word & Controlword::kEnableOperation) == 0 ? PowerCommand::switch_on
                                                     : PowerCommand::enable_operation;
}

}  // namespace vdrive
