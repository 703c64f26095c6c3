// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Controlwords 6040h: what one does, and what a drive with a habit (drive/habits.hpp) does later.

/// Command: 6040h was written. Runs the power state machine and the mode in force once, or waits
/// for the next look at it (5E20h:06).
void write_controlword(Drive& drive, std::uint16_t word);

/// Command, before all else in a tick in which something is held back: looks at 6040h, ends the
/// times of 5E20h:07 and 5E20h:08.
void begin_held_back(Drive& drive);

/// Command, behind the causes of faults: ends the time of 5E20h:09, so that a cause which persists
/// is a fault again with the next tick.
void end_held_back(Drive& drive);

}  // namespace vdrive
