// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace vdrive {

enum class HomingStage : std::uint8_t {
  idle,       // not started, or interrupted
  present,    // the present position is home
  search,     // towards the limit switch
  leave,      // away from it
  seek,       // towards the home switch
  seek_back,  // the same in reverse, after a limit switch
  clear,      // off the home switch, to the side from which home is approached
  approach,   // towards the edge of the home switch where home is
  push,       // towards the mechanical stop
  press,      // against it: the demand stands still
  index,      // towards the next index pulse
  back,       // home is known: back to it
  done,
  failed,
};

struct HomingState {
  HomingStage stage = HomingStage::idle;
  std::int8_t method = 0;  // 6098h
};

/// State that is used only during a run.
struct HomingRun {
  double pressed_at = 0.0;     // position of the axis in the first of the ticks `pressing` [UU]
  std::uint32_t pressing = 0;  // ticks for which the axis has stood against its mechanical stop
  bool home_input = false;     // state of the home switch in the last tick
  bool turned = false;         // demand and axis move in the direction of the present stage
  std::array<std::uint8_t, 2> unused{};
};

}  // namespace vdrive
