// SPDX-License-Identifier: Apache-2.0
#include "drive/window.hpp"

#include "drive/registers.hpp"
#include "drive/rounding.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <cmath>

namespace vdrive {

bool at_rest(const Drive& drive) {
  const DriveState& s = drive.state();
  return !s.demand.moving &&
         std::abs(actual_velocity(drive)) <= static_cast<double>(s.window.threshold);
}

bool on_target(const Drive& drive) {
  const TargetState& target = drive.state().target;
  const WindowState& window = drive.state().window;
  return target.arrived && !target.fresh &&
         (window.position == kWindowOff || window.dwell > window.position_ticks);
}

void count_ticks(bool inside, std::uint32_t& count) {
  if (!inside) {
    count = 0;
  } else if (count != kSaturatedCount) {
    ++count;
  }
}

void watch_target_window(Drive& drive) {
  WindowState& window = drive.state().window;
  const double distance = nearest(actual_position(drive)) - drive.state().target.position;
  const bool inside =
      window.position == kWindowOff || std::abs(distance) <= static_cast<double>(window.position);
  count_ticks(inside, window.dwell);
}

std::uint16_t reached_when(bool reached) {
  return reached ? Statusword::kTargetReached : 0U;
}

}  // namespace vdrive
