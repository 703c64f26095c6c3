// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Speeds of the velocity mode of frequency inverters (vl): conversion between the units of 6042h to
// 604Ah and velocities of 6064h. Questions only.
//   rpm of the motor = 6042h, 6043h, 6044h x set-point factor 604Bh x dimension factor 604Ch
//   rpm of the motor = 6046h, 6048h:01, 6049h:01, 604Ah:01 x |dimension factor 604Ch|

/// @return 6042h [UU/s], not limited.
[[nodiscard]] double vl_target(const Drive& drive);

/// @return 6042h limited by 6046h, 607Fh and 6080h [UU/s]. 0 stays 0: 6046h:01 applies only to an
///         axis that is commanded to turn.
[[nodiscard]] double limited_vl_target(const Drive& drive);

/// @return the ramp 6048h [UU/s²] within 60C5h; 0 counts as 1.
[[nodiscard]] double vl_acceleration(const Drive& drive);

/// @return the ramp 6049h [UU/s²] within 60C6h; 0 counts as 1.
[[nodiscard]] double vl_deceleration(const Drive& drive);

/// @return the ramp 604Ah [UU/s²] within 60C6h; 0 counts as 1.
[[nodiscard]] double vl_quick_stop_deceleration(const Drive& drive);

/// @return 6043h: the demand 606Bh as a velocity of the motor.
[[nodiscard]] std::int64_t vl_velocity_demand(const Drive& drive);

/// @return 6044h: the velocity of the motor, from encoder 1.
[[nodiscard]] std::int64_t vl_velocity_actual_value(const Drive& drive);

}  // namespace vdrive
