// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/motion/set_point_queue.hpp"

#include <array>
#include <cstdint>

namespace vdrive {

/// Profile position: the accepted set-points.
struct SetPointState {
  SetPointQueue queue;
  bool active = false;  // the active set-point has not been reached yet
  bool acknowledges_enabling =
      false;  // bit 12 is shown from transition 4 until a set-point is taken
  std::array<std::uint8_t, 2> unused{};
};

}  // namespace vdrive
