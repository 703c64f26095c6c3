// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace vdrive::ros2 {

/// What a joint is commanded with.
enum class Interface : std::uint8_t { position, velocity, effort };

/// @return "position", "velocity" or "effort".
[[nodiscard]] constexpr std::string_view to_string(Interface interface) noexcept {
  constexpr std::array<std::string_view, 3> kNames{"position", "velocity", "effort"};
  return kNames[static_cast<std::size_t>(interface)];
}

}  // namespace vdrive::ros2
