// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/drive.hpp"

namespace vdrive {

// What state, operating mode and controlword ask of the demand generator.

/// @return the motion that is asked for now. A limit switch may give up the set-points.
[[nodiscard]] MotionRequest requested_motion(const DriveContext& axis);

/// @return the loops that `request` needs closed.
[[nodiscard]] Control control_of(const DriveContext& axis, const MotionRequest& request);

}  // namespace vdrive
