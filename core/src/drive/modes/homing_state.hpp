// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace vdrive {

/// Where a homing run is.
enum class HomingStage : std::uint8_t {
  idle,       // not started, or interrupted
  present,    // the present position is home
  search,     // towards the limit switch
  leave,      // away from it
  seek,       // towards the home switch
  seek_back,  // the same, behind a limit switch: back
  clear,      // off the home switch, to the side from which home is approached
  approach,   // towards the edge of the home switch at which home lies
  push,       // towards the mechanical stop
  press,      // against it: the demand stands
  index,      // towards the next index pulse
  back,       // home is known: back to it
  done,
  failed,
};

/// Homing: the present run.
struct HomingState {
  HomingStage stage = HomingStage::idle;
  std::int8_t method = 0;  // 6098h
};

/// The same, as far as only a run looks at it.
struct HomingRun {
  double pressed_at = 0.0;     // where the axis was in the first of the ticks `pressing` [UU]
  std::uint32_t pressing = 0;  // ticks for which the axis stands against its mechanical stop
  bool home_input = false;     // home switch as it was in the last tick
  bool turned = false;         // demand and axis go the way of the present stage
  std::array<std::uint8_t, 2> unused{};
};

}  // namespace vdrive
