// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/registers.hpp"
#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Habits of other drives (5E20h): behaviour that differs from ours where CiA 402 leaves a choice,
// or that contradicts CiA 402. All habits are off by default and then cost one comparison per
// written word, transition or planned motion.

/// Command: converts 5E20h to the form used below, after it was written.
void update_habits(Drive& drive) noexcept;

/// Command, after transition 4: applies 5E20h:01 and 5E20h:0E.
void begin_operation(Drive& drive);

/// Command: records whether the next tick has to check something that is held back.
inline void note_waits(Drive& drive) {
  const HabitWaits& waits = drive.registers().waits;
  drive.state().power.waits = drive.registers().habits.loop != 0 || waits.has_word ||
                              waits.power_on != 0 || waits.mode != 0 || waits.reset != 0;
}

/// Command: starts to hold something back, which is released `ticks` ticks after the next tick.
inline void begin_wait(Drive& drive, std::uint32_t& wait, std::uint32_t ticks) {
  wait = ticks + 1U;  // the next tick counts down too
  drive.state().power.waits = true;
}

/// Command: the master is lost. Drops the commands that the drive has not carried out yet, so that
/// they cannot enable it.
inline void forget_commands(Drive& drive) {
  drive.registers().waits.power_on = 0;
  drive.registers().waits.has_word = false;
}

/// Question, 5E20h:02: whether the streamed position waits for bits 4 to 6 of 6040h.
[[nodiscard]] inline bool holds_stream(const Drive& drive) {
  constexpr unsigned kRelease =
      Controlword::kNewSetPoint | Controlword::kChangeSetImmediately | Controlword::kRelative;
  return drive.registers().habits.gates_stream &&
         (drive.state().controlword & kRelease) != kRelease;
}

/// Question, 5E20h:03: whether Quick stop active ends with the next tick, even if the axis still
/// moves.
[[nodiscard]] inline bool cuts_quick_stop(const Drive& drive) {
  return drive.registers().habits.cuts_quick_stop &&
         drive.state().power.machine.state() == PowerState::quick_stop_active;
}

/// Question, 5E20h:05: whether writing `wanted` to 6060h is refused now. Writing the value that
/// 6060h already has is no change.
[[nodiscard]] bool refuses_mode_change(const Drive& drive, OperatingMode wanted);

/// Question, 5E20h:08: whether 6061h has to wait before it follows 6060h.
[[nodiscard]] inline bool holds_mode(const Drive& drive) {
  return drive.registers().waits.mode != 0;
}

/// Question, 5E20h:0A: whether bit 10 in cyclic synchronous position shows that the demand is at
/// the last streamed point.
[[nodiscard]] inline bool shows_points(const Drive& drive) {
  return drive.registers().habits.shows_points;
}

/// Question, 5E20h:0B: whether a move in profile position mode that is planned again starts at
/// velocity 0.
[[nodiscard]] inline bool plans_from_rest(const Drive& drive, MotionRequest::Kind kind) {
  return drive.registers().habits.plans_from_rest && kind == MotionRequest::Kind::move &&
         drive.state().mode.actual == OperatingMode::profile_position;
}

/// Question, 5E20h:0D: whether a homing run lasts only while bit 4 of 6040h is 1.
[[nodiscard]] inline bool homes_by_level(const Drive& drive) {
  return drive.registers().habits.homes_by_level;
}

/// Question, 5E20h:0F: whether halt ends a homing run for good.
[[nodiscard]] inline bool ends_homing_at_halt(const Drive& drive) {
  return drive.registers().habits.ends_homing_at_halt;
}

/// Question, 5E20h:10: whether transition 4 is refused because no mode has been selected with
/// 6060h.
[[nodiscard]] inline bool lacks_mode(const Drive& drive) {
  return drive.registers().habits.needs_mode && drive.state().mode.wanted == OperatingMode::none;
}

}  // namespace vdrive
