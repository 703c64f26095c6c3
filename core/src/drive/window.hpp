// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/registers.hpp"
#include "drive/state.hpp"
#include "rounding.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <cmath>
#include <cstdint>

namespace vdrive {

// Conditions that must last before 6041h shows them. Inline because every tick uses them.

/// @return whether the demand has stopped and the actual speed is at or below 606Fh.
[[nodiscard]] inline bool at_rest(const Drive& drive) {
  const DriveState& s = drive.state();
  return !s.demand.moving &&
         std::abs(actual_velocity(drive)) <= static_cast<double>(s.window.threshold);
}

/// @return whether the demand rests on the target and the actual position has been within 6067h for
///         6068h.
[[nodiscard]] inline bool on_target(const Drive& drive) {
  const TargetState& target = drive.state().target;
  const WindowState& window = drive.state().window;
  return target.arrived && !target.fresh &&
         (window.position == kWindowOff || window.dwell > window.position_ticks);
}

/// Counts the successive ticks in which `inside` was true.
inline void count_ticks(bool inside, std::uint32_t& count) {
  if (!inside) {
    count = 0;
  } else if (count != kSaturatedCount) {
    ++count;
  }
}

/// Counts the present tick for the target window 6067h; call after the plant.
inline void watch_target_window(Drive& drive) {
  WindowState& window = drive.state().window;
  const double distance = nearest(actual_position(drive)) - drive.state().target.position;
  const bool inside =
      window.position == kWindowOff || std::abs(distance) <= static_cast<double>(window.position);
  count_ticks(inside, window.dwell);
}

/// @return bit 10 of 6041h if `reached`.
[[nodiscard]] inline std::uint16_t reached_when(bool reached) {
  return reached ? Statusword::kTargetReached : 0U;
}

}  // namespace vdrive
