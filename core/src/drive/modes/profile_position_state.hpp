// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/motion/set_point_queue.hpp"

namespace vdrive {

/// Profile position: the set-points that were accepted.
struct SetPointState {
  SetPointQueue queue;
  bool active = false;  // the active set-point is not reached yet
};

}  // namespace vdrive
