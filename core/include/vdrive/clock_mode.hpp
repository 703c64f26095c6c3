// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace vdrive {

/// How the drive time of a bench advances.
enum class ClockMode : std::uint8_t {
  realtime,  ///< with the wall clock
  lockstep,  ///< by `step` requests
  freerun,   ///< each tick follows the previous one immediately
};

inline constexpr std::array kClockModes{ClockMode::realtime, ClockMode::lockstep,
                                        ClockMode::freerun};

/// @return "realtime", "lockstep" or "freerun".
[[nodiscard]] constexpr std::string_view to_string(ClockMode mode) noexcept {
  switch (mode) {
    case ClockMode::realtime:
      return "realtime";
    case ClockMode::lockstep:
      return "lockstep";
    case ClockMode::freerun:
      return "freerun";
  }
  return "unknown";
}

/// @return the mode of that name, or nothing.
[[nodiscard]] constexpr std::optional<ClockMode> clock_mode_named(std::string_view name) noexcept {
  for (const ClockMode mode : kClockModes) {
    if (to_string(mode) == name) return mode;
  }
  return std::nullopt;
}

}  // namespace vdrive
