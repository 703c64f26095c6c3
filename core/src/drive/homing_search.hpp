// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"
#include "vdrive/cia402/homing_method.hpp"

namespace vdrive {

// The ways of a homing run up to its switch or its mechanical stop: where each stage leads, how
// fast, and when it ends.

/// @return the method of the present run, which has one: the run travels.
[[nodiscard]] const HomingMethodRow& homing_method_of(const Drive& drive);

/// @return direction in which the present stage travels: +1, -1, or 0.
[[nodiscard]] double homing_direction(const Drive& drive);

/// @return whether the present stage travels at 6099h:01, to find or leave a switch or a stop; home
///         itself is approached at 6099h:02.
[[nodiscard]] bool searches_at_speed(HomingStage stage);

/// @return the first stage of a run by `method`, which travels, from the switches as they are.
[[nodiscard]] HomingStage first_homing_stage(const Drive& drive, const HomingMethodRow& method);

/// Forgets the run of before, and sees the home switch as it is: an edge comes later.
void begin_homing_search(Drive& drive);

/// Stages `leave`: the limit switch of the method is left, or the other one is met (failed).
/// @return whether the limit switch has been left.
[[nodiscard]] bool leaves_limit_switch(Drive& drive);

/// Stages `seek` to `approach`: the next stage at an edge of the home switch or at a limit switch
/// (failed where the method does not turn there).
/// @return whether the edge at which home lies has been passed.
[[nodiscard]] bool passes_home_switch(Drive& drive);

/// Stages `push` and `press`: the axis stands with at least the torque 5E18h:01 in the direction of
/// the stop; a limit switch comes before the stop (failed).
/// @return whether that has lasted for 5E18h:02.
[[nodiscard]] bool meets_hard_stop(Drive& drive);

}  // namespace vdrive
