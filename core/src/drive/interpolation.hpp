// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Set-points that a master streams (607Ah, 60FFh, 6071h, 60C1h:01): when one counts, the way to it
// over 60C2h, and what becomes of the demand while none comes (5E12h). The modes 7 to 10 share it.

/// @return whether a set-point was written that counts.
[[nodiscard]] inline bool is_streaming(const Drive& drive) {
  return drive.state().modes.stream.stage != StreamStage::none;
}

/// Command: the set-point of the mode in force was written. It counts from its first write in
/// Operation enabled.
void note_set_point(Drive& drive);

/// Command: the set-points so far are forgotten, the next one that is written begins a stream.
void end_stream(Drive& drive);

/// Command, once a tick of a stream, whatever was written before it and in which order: another
/// set-point begins its way. The same one again is no other: a master that repeats it does not
/// delay it. Raises fault 8700h where 5E12h:02 in a row have not come.
/// @param set_point as it is in force, with its offset
/// @return false where that fault was raised.
[[nodiscard]] bool take_set_point(Drive& drive, std::int32_t set_point);

/// Question: the demand at the end of this tick, on the way from the demand of now, `start`, to
/// `target`. The way that is left is divided anew in each tick: no rounding adds up, and the last
/// part is all of it.
[[nodiscard]] double part_of_way(const Drive& drive, double start, double target);

/// Question: the internal position [UU] that `set_point` means: within 607Dh, by the shorter way
/// round the register, on a modulo axis round its range; with software limits between them.
[[nodiscard]] double streamed_position(const Drive& drive, std::int32_t set_point);

/// Question: the part of this tick of the way to that position, within 607Fh and 6080h.
[[nodiscard]] MotionRequest follow_position(const Drive& drive, std::int32_t set_point);

/// Question: whether the demand is at `set_point` or on its way there: neither a stop nor a limit
/// keeps it away, and it is not extrapolated.
[[nodiscard]] bool follows_position(const Drive& drive, std::int32_t set_point);

}  // namespace vdrive
