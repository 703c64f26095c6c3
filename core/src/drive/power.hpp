// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/drive.hpp"

namespace vdrive {

// Power stage, faults and operating mode of an axis.

/// @return the option codes and settings that the power state machine reads.
[[nodiscard]] PowerOptions power_options(const DriveContext& axis);

/// Switches the power stage; without power the demand follows the actual position.
void set_power(const DriveContext& axis, bool powered);

/// Carries out what transitions of the power state machine do to the axis.
void act(const DriveContext& axis, const TransitionSet& taken);

/// Enters a fault into 603Fh, 1001h and 1003h and starts its reaction.
void raise_fault(const DriveContext& axis, ErrorCode code);

/// Looks at the injected causes of faults (5E02h to 5E05h).
void watch_causes(const DriveContext& axis);

/// @return true while a cause persists that refuses the fault reset.
[[nodiscard]] bool cause_present(const DriveContext& axis);

/// Ends the stops of quick stop, fault reaction and held-back transitions.
void complete_stops(const DriveContext& axis);

/// 6061h follows 6060h outside Operation enabled and at rest; a moving axis brakes first.
void follow_mode(const DriveContext& axis);

}  // namespace vdrive
