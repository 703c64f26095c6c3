// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"
#include "vdrive/cia402/homing_method.hpp"

namespace vdrive {

// The part of a homing run up to its switch or mechanical stop: direction and speed of each stage,
// and when it ends.

/// @return the method of the present run, which must be one that travels.
[[nodiscard]] const HomingMethodRow& homing_method_of(const Drive& drive);

/// @return direction of travel of the present stage: +1, -1, or 0.
[[nodiscard]] double homing_direction(const Drive& drive);

/// @return whether `stage` travels at 6099h:01 to find or leave a switch or a stop. Home itself is
///         approached at 6099h:02.
[[nodiscard]] bool searches_at_speed(HomingStage stage);

/// @return the first stage of a run by `method`, which must travel, given the present switch
///         states.
[[nodiscard]] HomingStage first_homing_stage(const Drive& drive, const HomingMethodRow& method);

/// Forgets the previous run. Edges of the home switch count from its present state.
void begin_homing_search(Drive& drive);

/// Stage `leave`: the axis leaves the limit switch of the method, or meets the other one (failed).
/// @return whether it has left the limit switch.
[[nodiscard]] bool leaves_limit_switch(Drive& drive);

/// Stages `seek` to `approach`: goes to the next stage at an edge of the home switch or at a limit
/// switch (failed if the method does not turn there).
/// @return whether the edge at home has been passed.
[[nodiscard]] bool passes_home_switch(Drive& drive);

/// Stages `push` and `press`: watches for an axis at standstill that presses against the stop with
/// at least the torque 5E18h:01. A limit switch before the stop means failure.
/// @return whether the axis has pressed against the stop for the time 5E18h:02.
[[nodiscard]] bool meets_hard_stop(Drive& drive);

}  // namespace vdrive
