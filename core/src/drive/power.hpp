// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"
#include "vdrive/cia402/error_code.hpp"

namespace vdrive {

// Power stage of an axis: effect of the transitions of the power state machine.

/// Power-up: registers take their defaults and the state machine takes transition 0 and, with
/// `initialise`, 1. The mechanics stay as they are.
void power_up(Drive& drive, bool initialise) noexcept;

/// Transition 1, unless already done. If the memory check failed, the fault is raised here.
void complete_power_up(Drive& drive);

/// Loss of the master, 6007h.
void lose_connection(Drive& drive) noexcept;

/// The power stage drops out without a command (5E0Bh): neither a fault nor a stop. The axis coasts
/// until a controlword enables it again.
void drop_power(Drive& drive) noexcept;

/// @return the option codes and settings for the power state machine.
[[nodiscard]] PowerOptions power_options(const Drive& drive);

/// Applies the transitions of the power state machine to the axis.
void act(Drive& drive, const TransitionSet& taken);

/// Enters a fault into 603Fh, 1001h and 1003h and starts its reaction.
void raise_fault(Drive& drive, ErrorCode code);

/// Raises the faults whose causes have appeared (5E02h to 5E05h, heat of the motor).
void watch_causes(Drive& drive);

/// Ends the stops of quick stop, fault reaction and pending transitions.
void complete_stops(Drive& drive);

}  // namespace vdrive
