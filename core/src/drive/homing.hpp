// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/drive.hpp"

namespace vdrive {

// Homing mode (CiA 402-2): methods 1, 2, 17, 18, 33, 34, 35 and 37 of 6098h.

/// @return whether 6098h takes `value`: 0 (no method) or a supported method.
[[nodiscard]] bool is_homing_method(std::int64_t value);

/// @return true from the start of a run to its end, the way back to home included.
[[nodiscard]] bool homing_runs(HomingStage stage);

/// @return direction in which the present stage travels at 6099h: +1, -1, or 0.
[[nodiscard]] double homing_direction(const DriveContext& axis);

/// Rising edge of controlword bit 4: starts a run by 6098h.
/// @return false when a run is under way, which ignores the edge.
bool start_homing(const DriveContext& axis);

/// Looks at switches, index pulse and position of the last tick; may go on to the next stage.
void advance_homing(const DriveContext& axis);

/// Halt or a stop ends a run that is under way; what one has found or not found before stays.
void interrupt_homing(const DriveContext& axis);

}  // namespace vdrive
