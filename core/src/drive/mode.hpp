// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/limits.hpp"
#include "drive/registers.hpp"
#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

/// A controlword that was written; DriveState already holds it.
struct WrittenControlword {
  std::uint16_t previous = 0;  // the controlword in force before
  bool accepting = false;      // the mode is in control before and after this word
};

/// Interface of an operating mode to the rest of the drive. Each file in drive/modes fills in what
/// it needs; members left out do nothing.
struct Mode {
  /// Ramp object [UU/s²] of the normal stop. If that stop only removes the torque, the axis brakes
  /// with this ramp before a change of mode.
  ObjectRow normal_ramp = 0;

  /// The normal stop follows the profile of 6086h, like the motions of the mode.
  bool has_profile_type = false;

  /// Command: a controlword was written.
  void (*command)(Drive& drive, const WrittenControlword& word) = nullptr;

  /// Command: 607Ah, 6042h, 60FFh, 6071h, 60C1h:01 or an offset (60B0h, 60B1h, 60B2h) was written.
  void (*take_target)(Drive& drive, ObjectRow row) = nullptr;

  /// Command, before the drive asks for a motion: advances the mode according to the readings of
  /// the last tick, and gives up its target at a limit switch. Not called in ticks in which only
  /// the motion continues.
  void (*advance)(Drive& drive) = nullptr;

  /// Question: the motion requested by the mode in Operation enabled.
  MotionRequest (*ask)(const Drive& drive) = nullptr;

  /// Question: the normal stop, if it differs from a ramp with `normal_ramp`.
  MotionRequest (*normal_stop)(const Drive& drive) = nullptr;

  /// Question: the stop with the quick ramp and at a limit switch, if it differs from a ramp with
  /// 6085h.
  MotionRequest (*quick_stop)(const Drive& drive) = nullptr;

  /// Question: the torque that the mode adds to the command of the loops [‰ of rated], also during
  /// its stops. For modes that close the velocity loop.
  double (*torque_offset)(const Drive& drive) = nullptr;

  /// Command, after the plant: counts conditions that must last for a time.
  void (*watch)(Drive& drive) = nullptr;

  /// Command, after `watch`: takes the next set-point.
  void (*take_next)(Drive& drive) = nullptr;

  /// Question: bits 10 to 13 of 6041h in Operation enabled; bit 11 if the mode itself limits its
  /// target.
  std::uint16_t (*status_bits)(const Drive& drive) = nullptr;

  /// True if, while the demand moves outside the target window, `watch` and `take_next` do nothing
  /// and `status_bits` stay the same.
  bool moves_steadily = false;

  /// Question: whether the requested motion may change without a write.
  bool (*evolves)(const Drive& drive) = nullptr;
};

/// For modes in which bit 4 has no meaning: counts its rising edge as ignored.
void ignore_edge(Drive& drive, const WrittenControlword& word);

/// @return whether the active mode controls the motion: no stop, no change of mode.
[[nodiscard]] inline bool obeys_mode(const Drive& drive) {
  const DriveState& s = drive.state();
  return s.power.on && operation_enabled(drive) && s.mode.wanted == s.mode.actual &&
         s.power.machine.pending() == PowerCommand::none;
}

/// Command: gives up the target for good if it leads into an active limit switch; a new one must be
/// written.
/// @param direction direction of the target, by its sign; 0 = none
/// @return whether the target was given up.
inline bool give_up_target_at_limit_switch(Drive& drive, double direction) {
  if (!obeys_mode(drive) || !runs_into_limit_switch(drive, direction)) return false;
  drive.state().target.given_up = true;
  return true;
}

}  // namespace vdrive
