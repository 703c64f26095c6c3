// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::service {

/// Why a window was frozen.
struct WindowCause {
  enum class Kind : std::uint8_t {
    fault = 1,        ///< code: 603Fh
    master_lost = 2,  ///< axis: the axis that lost its master, 0 = all axes of a session
    stopped = 3,      ///< a session that does not own the axis stopped it
    asked = 4,        ///< requested by REQUEST_FREEZE_WINDOW
  };

  Kind kind = Kind::fault;
  std::uint16_t axis = 0;  ///< number on the bench, 0 = the bench
  std::uint32_t code = 0;
  std::uint64_t session = 0;
  std::uint64_t tick = 0;
};

/// A range of ticks that the black box keeps.
struct Window {
  static constexpr std::size_t kMostCauses = 16;
  static constexpr std::size_t kMostSegments = 32;

  std::uint64_t number = 0;
  std::uint64_t first_tick = 0;
  std::uint64_t last_tick = 0;
  std::uint32_t more_causes = 0;  ///< causes that did not fit into `causes`
  std::uint32_t cause_count = 0;
  std::uint32_t segment_count = 0;
  std::array<WindowCause, kMostCauses> causes{};  ///< the first one froze the window
  std::array<std::uint32_t, kMostSegments> segments{};
};

/// The maximum number of windows kept for a bench.
inline constexpr std::size_t kMostWindows = 16;

/// @param windows at least one, oldest first
/// @return the index of the window to drop: the oldest one of the most frequent kind and code.
[[nodiscard]] inline std::size_t place_to_drop(std::span<const Window> windows) noexcept {
  const auto count_alike = [windows](const Window& window) {
    return std::ranges::count_if(windows, [&](const Window& other) {
      return window.causes[0].kind == other.causes[0].kind &&
             window.causes[0].code == other.causes[0].code;
    });
  };
  return static_cast<std::size_t>(std::ranges::max_element(windows, {}, count_alike) -
                                  windows.begin());
}

}  // namespace vdrive::service
