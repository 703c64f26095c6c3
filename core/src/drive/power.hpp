// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"
#include "vdrive/cia402/error_code.hpp"

namespace vdrive {

// Power stage of an axis: what the transitions of the power state machine do to it.

/// Power-up: registers take defaults, the state machine passes transitions 0 and, when
/// `initialise`, 1. The mechanics stay as they are.
void power_up(Drive& drive, bool initialise) noexcept;

/// Transition 1, unless it is done already. What the memory check found is a fault from there on.
void complete_power_up(Drive& drive);

/// The silent master of 6007h.
void lose_connection(Drive& drive) noexcept;

/// The power stage drops out by itself (5E0Bh): no fault, and no stop. The axis coasts, until a
/// controlword enables it again.
void drop_power(Drive& drive) noexcept;

/// @return the option codes and settings that the power state machine reads.
[[nodiscard]] PowerOptions power_options(const Drive& drive);

/// Carries out what transitions of the power state machine do to the axis.
void act(Drive& drive, const TransitionSet& taken);

/// Enters a fault into 603Fh, 1001h and 1003h and starts its reaction.
void raise_fault(Drive& drive, ErrorCode code);

/// Raises the faults whose causes have come (5E02h to 5E05h).
void watch_causes(Drive& drive);

/// Ends the stops of quick stop, fault reaction and held-back transitions.
void complete_stops(Drive& drive);

}  // namespace vdrive
