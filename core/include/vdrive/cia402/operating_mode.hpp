// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace vdrive {

/// Operating modes of 6060h and 6061h that the drive has (CiA 402-2, modes of operation).
enum class OperatingMode : std::int8_t {
  none = 0,  ///< empty mode: enabled, no motion
  profile_position = 1,
  profile_velocity = 3,
  profile_torque = 4,
  homing = 6,
  cyclic_synchronous_position = 8,
};

/// Value of 6502h: bit n - 1 stands for mode n.
inline constexpr std::uint32_t kSupportedDriveModes =
    1U << 0U | 1U << 2U | 1U << 3U | 1U << 5U | 1U << 7U;

/// @return whether 6060h takes `value`: 0 or a mode that 6502h shows.
[[nodiscard]] constexpr bool is_operating_mode(std::int64_t value) noexcept {
  return value == 0 ||
         (value > 0 && value <= 32 && (kSupportedDriveModes >> (value - 1) & 1U) != 0);
}

/// @return the standard's name of `mode`, such as "profile position".
[[nodiscard]] std::string_view to_string(OperatingMode mode) noexcept;

}  // namespace vdrive
