// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/drive.hpp"

namespace vdrive {

// Monitors of an axis and its status image.

/// Following error 60F4h against 6065h and 6066h; `error` in [UU].
void watch_following_error(const DriveContext& axis, double error);

/// Writes statusword 6041h from whole internal positions [UU]; judges the target window.
void compose_statusword(const DriveContext& axis, double demand, double actual);

/// Writes every other object of the status image.
void fill_status(const DriveContext& axis);

}  // namespace vdrive
