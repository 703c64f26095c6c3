// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Effect of a written controlword 6040h: immediate, or delayed on a drive with a habit
// (drive/habits.hpp).

/// Command: 6040h was written. Runs the power state machine and the active mode once, or leaves the
/// word for the next read (5E20h:06).
void write_controlword(Drive& drive, std::uint16_t word);

/// Command, at the start of a tick in which a habit holds something back: reads 6040h and counts
/// down 5E20h:07 and 5E20h:08.
void begin_held_back(Drive& drive);

/// Command, later in such a tick, after the check for causes of faults: counts down 5E20h:09. A
/// cause that persists therefore raises a fault again in the next tick.
void end_held_back(Drive& drive);

}  // namespace vdrive
