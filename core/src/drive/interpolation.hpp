// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Set-points streamed by a master (607Ah, 60FFh, 6071h, 60C1h:01): which of them count, the
// interpolation over 60C2h, and the demand while none arrive (5E12h). Shared by modes 7 to 10.

/// @return whether a set-point that counts has been written.
[[nodiscard]] inline bool is_streaming(const Drive& drive) {
  return drive.state().modes.stream.stage != StreamStage::none;
}

/// Command: the set-point of the active mode was written. Set-points count from the first write in
/// Operation enabled.
void note_set_point(Drive& drive);

/// Command: forgets the set-points so far; the next one written starts a stream.
void end_stream(Drive& drive);

/// Command, once per tick of a stream, after all writes that precede the tick: starts the
/// interpolation if the set-point has changed. Repeating a set-point does not restart it, except
/// after an extrapolation. Raises fault 8700h if 5E12h:02 set-points in a row are missing.
/// @param set_point the effective value, including its offset
/// @return false if that fault was raised.
[[nodiscard]] bool take_set_point(Drive& drive, std::int32_t set_point);

/// Question: the demand at the end of this tick, on the way from the present demand `start` to
/// `target`. The remaining distance is divided again in every tick, so rounding errors do not add
/// up and the last part reaches the target.
[[nodiscard]] double interpolated_demand(const Drive& drive, double start, double target);

/// Question: the internal position [UU] for `set_point`, limited by 607Dh. With software limits the
/// path to it stays within them; otherwise it is the shorter way round the register or, on a modulo
/// axis, round its range.
[[nodiscard]] double streamed_position(const Drive& drive, std::int32_t set_point);

/// Question: the motion in this tick towards streamed_position() or, while set-points are missing,
/// by 5E12h:01, within 607Fh and 6080h.
[[nodiscard]] MotionRequest follow_position(const Drive& drive, std::int32_t set_point);

/// Question: whether the demand is at `set_point` or on its way there, that is, neither stopped nor
/// limited nor extrapolated.
[[nodiscard]] bool follows_position(const Drive& drive, std::int32_t set_point);

}  // namespace vdrive
