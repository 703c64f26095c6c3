// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Limits of position and torque, and limit switches. Questions only.

/// @return `target` [UU], limited by 607Dh if that is in force.
[[nodiscard]] double within_software_limits(const Drive& drive, double target);

/// @return `torque` [‰ of rated], limited by 6072h, 60E0h and 60E1h. The target of a torque ramp is
///         limited too: a demand beyond the limits would have no effect, and the next ramp would
///         first have to bring it back.
[[nodiscard]] double within_torque_limits(const Drive& drive, double torque);

/// @return whether the limit switch in `direction` (not 0) is active.
[[nodiscard]] bool at_limit_switch(const Drive& drive, double direction);

/// @return whether a limit switch is active in the direction of `motion`, which may be 0.
[[nodiscard]] bool runs_into_limit_switch(const Drive& drive, double motion);

/// @return whether the actual velocity, if above 606Fh, leads into an active limit switch. For
///         modes that do not command a velocity.
[[nodiscard]] bool drifts_into_limit_switch(const Drive& drive);

/// @return `limit_bits` for an axis that has limits or active inputs.
[[nodiscard]] std::uint16_t bits_at_limits(const Drive& drive, double internal_demand,
                                           double internal_actual);

/// @return bits of 6041h: bit 11 if demand or actual position is at or beyond a software limit, or
///         a limit switch is active; bit 7 if the actual position is beyond a software limit. The
///         positions are internal and whole [UU].
[[nodiscard]] inline std::uint16_t limit_bits(const Drive& drive, double internal_demand,
                                              double internal_actual) {
  const LimitState& limits = drive.state().limits;
  const bool free = limits.inputs == 0 && !limits.enabled;
  return free ? std::uint16_t{0} : bits_at_limits(drive, internal_demand, internal_actual);
}

}  // namespace vdrive
