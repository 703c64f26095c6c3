// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Ramps, and the requests that bring an axis to rest. Questions only.

/// @return the ramp in `row` [UU/s²] within 60C5h; 0 counts as 1.
[[nodiscard]] double acceleration_of(const Drive& drive, ObjectRow row);

/// @return the ramp in `row` [UU/s²] within 60C6h; 0 counts as 1.
[[nodiscard]] double deceleration_of(const Drive& drive, ObjectRow row);

/// @return 60A3h and 60A4h if 6086h selects limited jerk, otherwise unlimited.
[[nodiscard]] MotionJerk profile_jerk(const Drive& drive);

/// @return the stop with `deceleration` [UU/s²].
[[nodiscard]] MotionRequest stop_with(double deceleration);

/// @return the stop with the ramp in `row`.
[[nodiscard]] MotionRequest ramp_stop(const Drive& drive, ObjectRow row);

/// @return the same stop with the profile of 6086h.
[[nodiscard]] MotionRequest profile_stop(const Drive& drive, ObjectRow row);

/// @return the torque ramp to `target` [‰ of rated] with slope 6087h; 0 counts as 1.
[[nodiscard]] MotionRequest torque_to(const Drive& drive, double target);

/// @return the normal stop of modes that command a torque: the torque is removed with slope 6087h.
[[nodiscard]] MotionRequest release_torque(const Drive& drive);

/// @return the stop with 6085h at a limit switch, for a mode without its own quick ramp.
[[nodiscard]] MotionRequest limit_switch_stop(const Drive& drive);

/// Deceleration for option codes 605Ah, 605Dh and 605Eh: 1 normal ramp, 2 quick ramp, 3 and 4 the
/// steepest allowed.
/// @param normal the deceleration of the normal ramp [UU/s²]
[[nodiscard]] double option_deceleration(const Drive& drive, std::int64_t option, double normal);

/// @param normal the stop of option 1
/// @return the stop for an option code.
[[nodiscard]] MotionRequest stop_by_option(const Drive& drive, std::int64_t option,
                                           const MotionRequest& normal);

}  // namespace vdrive
