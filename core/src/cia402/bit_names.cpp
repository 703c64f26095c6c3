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
    BitName{Statusword::kReadyToSwitchOn, "ready to switch on", "准备接通"},
    BitName{Statusword::kSwitchedOn, "switched on", "已接通"},
    BitName{Statusword::kOperationEnabled, "operation enabled", "运行使能"},
    BitName{Statusword::kFault, "fault", "故障"},
    BitName{Statusword::kVoltageEnabled, "voltage enabled", "电压使能"},
    BitName{Statusword::kQuickStop, "quick stop", "快速停机（0 有效）"},
    BitName{Statusword::kSwitchOnDisabled, "switch on disabled", "禁止接通"},
    BitName{Statusword::kWarning, "warning", "警告"},
    BitName{Statusword::kRemote, "remote", "远程"},
    BitName{Statusword::kTargetReached, "target reached", "到达目标"},
    BitName{Statusword::kInternalLimitActive, "internal limit active", "内部限制有效"},
    BitName{kBit12, "bit 12", "位 12"},
    BitName{kBit13, "following error", "跟随误差"},
};

constexpr std::array kControlBits{
    BitName{Controlword::kSwitchOn, "switch on", "接通"},
    BitName{Controlword::kEnableVoltage, "enable voltage", "使能电压"},
    BitName{Controlword::kQuickStop, "quick stop", "快速停机（0 有效）"},
    BitName{Controlword::kEnableOperation, "enable operation", "使能运行"},
    BitName{Controlword::kFaultReset, "fault reset", "故障复位"},
    BitName{Controlword::kHalt, "halt", "暂停"},
};

/// @return the names of `bit`, empty if it has none.
BitName find_names(std::uint16_t bit, std::span<const BitName> names) {
  const auto found = std::ranges::find(names, bit, &BitName::bit);
  return found == names.end() ? BitName{} : *found;
}

/// A name specific to the mode takes precedence over the common one.
BitName names_of(std::uint16_t bit, std::span<const BitName> of_mode,
                 std::span<const BitName> of_all) {
  const BitName names = find_names(bit, of_mode);
  return names.name.empty() ? find_names(bit, of_all) : names;
}

/// For a mode without a row: it has no specific bits.
constexpr OperatingModeRow kUnknownMode{};

const OperatingModeRow& row_of(OperatingMode mode) {
  const OperatingModeRow* const row = find_operating_mode(mode);
  return row == nullptr ? kUnknownMode : *row;
}

}  // namespace

BitName statusword_bit_names(std::uint16_t bit, OperatingMode mode) noexcept {
  return names_of(bit, row_of(mode).status_bits, kStatusBits);
}

BitName controlword_bit_names(std::uint16_t bit, OperatingMode mode) noexcept {
  return names_of(bit, row_of(mode).control_bits, kControlBits);
}

std::string_view statusword_bit_name(std::uint16_t bit, OperatingMode mode) noexcept {
  return statusword_bit_names(bit, mode).name;
}

std::string_view controlword_bit_name(std::uint16_t bit, OperatingMode mode) noexcept {
  return controlword_bit_names(bit, mode).name;
}

}  // namespace vdrive
