// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace vdrive::service {

/// The reaction of a bench to a step of the wall clock.
enum class WallStepPolicy : std::uint8_t {
  steer,  ///< drive time continues without a break and is adjusted, however long that takes
  jump,   ///< forward: the tick number jumps; backward: as steer, because no number is used twice
};

[[nodiscard]] constexpr std::string_view to_string(WallStepPolicy policy) noexcept {
  return policy == WallStepPolicy::steer ? "steer" : "jump";
}

/// The maximum rate at which drive time is adjusted to the wall clock, as a fraction.
inline constexpr double kMaxSteering = 500e-6;

}  // namespace vdrive::service
