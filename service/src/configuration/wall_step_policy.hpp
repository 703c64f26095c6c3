// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace vdrive::service {

/// What a bench does when the wall clock was changed.
enum class WallStepPolicy : std::uint8_t {
  steer,  ///< drive time continues without a break and is adjusted, however long that takes
  jump,   ///< forward, the tick number jumps; backward as steer, since no number comes twice
};

[[nodiscard]] constexpr std::string_view to_string(WallStepPolicy policy) noexcept {
  return policy == WallStepPolicy::steer ? "steer" : "jump";
}

/// By how much drive time is adjusted to the wall clock at most, as a part of it.
inline constexpr double kMaxSteering = 500e-6;

}  // namespace vdrive::service
