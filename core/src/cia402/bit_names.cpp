// SPDX-License-Identifier: Apache-2.0
#include "vdrive/cia402/bit_names.hpp"

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace vdrive {
namespace {

struct BitRow {
  std::uint16_t bit;
  std::string_view name;
};

/// A bit that a mode reads in its own way.
struct ModeBitRow {
  OperatingMode mode;
  std::uint16_t bit;
  std::string_view name;
};

constexpr std::uint16_t kBit12 = 1U << 12U;
constexpr std::uint16_t kBit13 = 1U << 13U;

constexpr std::array kStatusBits{
    BitRow{Statusword::kReadyToSwitchOn, "ready to switch on"},
    BitRow{Statusword::kSwitchedOn, "switched on"},
    BitRow{Statusword::kOperationEnabled, "operation enabled"},
    BitRow{Statusword::kFault, "fault"},
    BitRow{Statusword::kVoltageEnabled, "voltage enabled"},
    BitRow{Statusword::kQuickStop, "quick stop"},
    BitRow{Statusword::kSwitchOnDisabled, "switch on disabled"},
    BitRow{Statusword::kWarning, "warning"},
    BitRow{Statusword::kRemote, "remote"},
    BitRow{Statusword::kTargetReached, "target reached"},
    BitRow{Statusword::kInternalLimitActive, "internal limit active"},
    BitRow{kBit12, "bit 12"},
    BitRow{kBit13, "following error"},
};

constexpr std::array kModeStatusBits{
    ModeBitRow{OperatingMode::profile_position, Statusword::kSetPointAcknowledge,
               "set-point acknowledge"},
    ModeBitRow{OperatingMode::profile_velocity, Statusword::kSpeedZero, "speed zero"},
    ModeBitRow{OperatingMode::homing, Statusword::kHomingAttained, "homing attained"},
    ModeBitRow{OperatingMode::homing, Statusword::kHomingError, "homing error"},
    ModeBitRow{OperatingMode::cyclic_synchronous_position, Statusword::kFollowsCommand,
               "follows command"},
};

constexpr std::array kControlBits{
    BitRow{Controlword::kSwitchOn, "switch on"},
    BitRow{Controlword::kEnableVoltage, "enable voltage"},
    BitRow{Controlword::kQuickStop, "quick stop"},
    BitRow{Controlword::kEnableOperation, "enable operation"},
    BitRow{Controlword::kFaultReset, "fault reset"},
    BitRow{Controlword::kHalt, "halt"},
};

constexpr std::array kModeControlBits{
    ModeBitRow{OperatingMode::profile_position, Controlword::kNewSetPoint, "new set-point"},
    ModeBitRow{OperatingMode::profile_position, Controlword::kChangeSetImmediately,
               "change set immediately"},
    ModeBitRow{OperatingMode::profile_position, Controlword::kRelative, "relative"},
    ModeBitRow{OperatingMode::homing, Controlword::kStartHoming, "start homing"},
};

/// A name of the mode takes precedence over one of all modes.
std::string_view name_of(std::uint16_t bit, OperatingMode mode,
                         std::span<const ModeBitRow> mode_rows, std::span<const BitRow> rows) {
  const auto of_mode = std::ranges::find_if(mode_rows, [bit, mode](const ModeBitRow& row) {
    return row.mode == mode && row.bit == bit;
  });
  if (of_mode != mode_rows.end()) return of_mode->name;
  const auto found = std::ranges::find(rows, bit, &BitRow::bit);
  return found == rows.end() ? std::string_view{} : found->name;
}

}  // namespace

std::string_view statusword_bit_name(std::uint16_t bit, OperatingMode mode) noexcept {
  return name_of(bit, mode, kModeStatusBits, kStatusBits);
}

std::string_view controlword_bit_name(std::uint16_t bit, OperatingMode mode) noexcept {
  return name_of(bit, mode, kModeControlBits, kControlBits);
}

}  // namespace vdrive
