// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/limits.hpp"
#include "drive/registers.hpp"
#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

/// A controlword was written; DriveState holds it already.
struct WrittenControlword {
  std::uint16_t previous = 0;  // the controlword in force before
  bool accepting = false;      // the mode was in force before and is after this word
};

/// What an operating mode is to the rest of the drive. Its file in drive/modes fills in what it
/// needs; what it leaves out does nothing.
struct Mode {
  /// Ramp object of the normal stop [UU/s²], and of a change of the mode where the normal stop
  /// takes a torque back.
  ObjectRow normal_ramp = 0;

  /// The normal stop is by the profile of 6086h, as the motions of the mode are.
  bool has_profile_type = false;

  /// Command: a controlword was written.
  void (*command)(Drive& drive, const WrittenControlword& word) = nullptr;

  /// Command: 607Ah, 6042h, 60FFh, 6071h, 60C1h:01 or an offset (60B0h, 60B1h, 60B2h) was written.
  void (*take_target)(Drive& drive, ObjectRow row) = nullptr;

  /// Command, before the drive asks for a motion: readings of the last tick take the mode on, a
  /// limit switch takes its target away. Not called while nothing but the motion happens.
  void (*advance)(Drive& drive) = nullptr;

  /// Question: the motion that the mode asks for in Operation enabled.
  MotionRequest (*ask)(const Drive& drive) = nullptr;

  /// Question: the normal stop, where it is another one than that with `normal_ramp`.
  MotionRequest (*normal_stop)(const Drive& drive) = nullptr;

  /// Question: the stop by the quick ramp and at a limit switch, where it is another one than that
  /// with 6085h.
  MotionRequest (*quick_stop)(const Drive& drive) = nullptr;

  /// Question: the torque that the mode adds to what the loops command [‰ of rated]; in its stops,
  /// too. For modes that close the velocity loop.
  double (*torque_offset)(const Drive& drive) = nullptr;

  /// Command, after the plant: counts what has to last.
  void (*watch)(Drive& drive) = nullptr;

  /// Command, after `watch`: takes the next set-point.
  void (*take_next)(Drive& drive) = nullptr;

  /// Question: bits 10 to 13 of 6041h in Operation enabled; bit 11 where the mode itself limits its
  /// target.
  std::uint16_t (*status_bits)(const Drive& drive) = nullptr;

  /// Where the demand moves outside of the target window, `watch` and `take_next` do nothing and
  /// `status_bits` stay as they are.
  bool moves_steadily = false;

  /// Question: whether what the mode asks for may change by itself, without a write.
  bool (*evolves)(const Drive& drive) = nullptr;
};

/// Bit 4 means nothing where no mode takes it: its rising edge is ignored and counted.
void ignore_edge(Drive& drive, const WrittenControlword& word);

/// @return whether the mode in force decides on the motion: no stop, no change of the mode.
[[nodiscard]] inline bool obeys_mode(const Drive& drive) {
  const DriveState& s = drive.state();
  return s.power.on && operation_enabled(drive) && s.mode.wanted == s.mode.actual &&
         s.power.machine.pending() == PowerCommand::none;
}

/// Command: gives the target up when it leads into an active limit switch, for good: a new one has
/// to be written.
/// @param direction in which the target leads, by its sign; 0 = nowhere
/// @return whether the target was given up.
inline bool heed_limit_switch(Drive& drive, double direction) {
  if (!obeys_mode(drive) || !runs_into_limit_switch(drive, direction)) return false;
  drive.state().target.given_up = true;
  return true;
}

}  // namespace vdrive
