// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/operating_mode.hpp"

#include <cstdint>
#include <string_view>

namespace vdrive {

/// @param bit one bit of the statusword 6041h, such as Statusword::kFault
/// @return the name of the bit in `mode`, such as "target reached"; empty where it has none. Bit 13
///         has the meaning of the mode only in Operation enabled; in other states pass
///         OperatingMode::none.
[[nodiscard]] std::string_view statusword_bit_name(std::uint16_t bit, OperatingMode mode) noexcept;

/// @param bit one bit of the controlword 6040h, such as Controlword::kHalt
/// @return the name of the bit in `mode`, such as "new set-point"; empty where it has none.
[[nodiscard]] std::string_view controlword_bit_name(std::uint16_t bit, OperatingMode mode) noexcept;

/// @return the name of `bit` in both languages.
[[nodiscard]] BitName statusword_bit_names(std::uint16_t bit, OperatingMode mode) noexcept;

/// @return the name of `bit` in both languages.
[[nodiscard]] BitName controlword_bit_names(std::uint16_t bit, OperatingMode mode) noexcept;

}  // namespace vdrive
