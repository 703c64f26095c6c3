// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdrive {

/// Where a homing run is.
enum class HomingStage : std::uint8_t {
  idle,     // not started, or interrupted
  present,  // the present position is home
  search,   // towards the limit switch
  leave,    // away from it
  index,    // towards the next index pulse
  back,     // home is known: back to it
  done,
  failed,
};

/// Homing: the present run.
struct HomingState {
  HomingStage stage = HomingStage::idle;
  std::int8_t method = 0;  // 6098h
};

}  // namespace vdrive
