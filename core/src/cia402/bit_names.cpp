// SPDX-License-Identifier: Apache-2.0
#include "vdrive/cia402/bit_names.hpp"

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace vdrive {
namespace {

constexpr std::uint16_t kBit12 = 1U << 12U;
constexpr std::uint16_t kBit13 = 1U << 13U;

constexpr std::array kStatusBits{
    BitName{Statusword::kReadyToSwitchOn, "ready to switch on"},
    BitName{Statusword::kSwitchedOn, "switched on"},
    BitName{Statusword::kOperationEnabled, "operation enabled"},
    BitName{Statusword::kFault, "fault"},
    BitName{Statusword::kVoltageEnabled, "voltage enabled"},
    BitName{Statusword::kQuickStop, "quick stop"},
    BitName{Statusword::kSwitchOnDisabled, "switch on disabled"},
    BitName{Statusword::kWarning, "warning"},
    BitName{Statusword::kRemote, "remote"},
    BitName{Statusword::kTargetReached, "target reached"},
    BitName{Statusword::kInternalLimitActive, "internal limit active"},
    BitName{kBit12, "bit 12"},
    BitName{kBit13, "following error"},
};

constexpr std::array kControlBits{
    BitName{Controlword::kSwitchOn, "switch on"},
    BitName{Controlword::kEnableVoltage, "enable voltage"},
    BitName{Controlword::kQuickStop, "quick stop"},
    BitName{Controlword::kEnableOperation, "enable operation"},
    BitName{Controlword::kFaultReset, "fault reset"},
    BitName{Controlword::kHalt, "halt"},
};

/// @return the name of `bit`, empty where it has none.
std::string_view find_name(std::uint16_t bit, std::span<const BitName> names) {
  const auto found = std::ranges::find(names, bit, &BitName::bit);
  return found == names.end() ? std::string_view{} : found->name;
}

/// A name of the mode takes precedence over one of all modes.
std::string_view name_of(std::uint16_t bit, std::span<const BitName> of_mode,
                         std::span<const BitName> of_all) {
  const std::string_view name = find_name(bit, of_mode);
  return name.empty() ? find_name(bit, of_all) : name;
}

/// A mode without a row reads no bit in its own way.
constexpr OperatingModeRow kUnknownMode{};

const OperatingModeRow& row_of(OperatingMode mode) {
  const OperatingModeRow* const row = find_operating_mode(mode);
  return row == nullptr ? kUnknownMode : *row;
}

}  // namespace

std::string_view statusword_bit_name(std::uint16_t bit, OperatingMode mode) noexcept {
  return name_of(bit, row_of(mode).status_bits, kStatusBits);
}

std::string_view controlword_bit_name(std::uint16_t bit, OperatingMode mode) noexcept {
  return name_of(bit, row_of(mode).control_bits, kControlBits);
}

}  // namespace vdrive
