// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drive/registers.hpp"
#include "drive/state.hpp"

#include <cstdint>

namespace vdrive {

// Habits of other drives (5E20h): what drives do differently where CiA 402 is open, or against it.
// Everything that asks for a habit asks here. All are off by default; what they cost then is a
// comparison where a word is written, a transition is taken or a motion is planned.

/// Command: puts 5E20h into the form in which it is asked for; after it was written.
void update_habits(Drive& drive) noexcept;

/// Command: transition 4 was taken. 5E20h:01 and 5E20h:0E.
void begin_operation(Drive& drive);

/// Command: notes whether the drive has to look at what it holds back in the next tick.
inline void note_waits(Drive& drive) {
  const HabitWaits& waits = drive.registers().waits;
  drive.state().power.waits = drive.registers().habits.loop != 0 || waits.has_word ||
                              waits.power_on != 0 || waits.mode != 0 || waits.reset != 0;
}

/// Command: begins to hold something back for `ticks`, the next one not included.
inline void begin_wait(Drive& drive, std::uint32_t& wait, std::uint32_t ticks) {
  wait = ticks + 1U;  // the next tick counts, too
  drive.state().power.waits = true;
}

/// Command: the master is lost. What it commanded and the drive has not done yet enables nothing
/// any more.
inline void forget_commands(Drive& drive) {
  drive.registers().waits.power_on = 0;
  drive.registers().waits.has_word = false;
}

/// Question, 5E20h:02: the streamed position waits for bits 4 to 6 of 6040h.
[[nodiscard]] inline bool holds_stream(const Drive& drive) {
  constexpr unsigned kRelease =
      Controlword::kNewSetPoint | Controlword::kChangeSetImmediately | Controlword::kRelative;
  return drive.registers().habits.gates_stream &&
         (drive.state().controlword & kRelease) != kRelease;
}

/// Question, 5E20h:03: Quick stop active ends with the next tick, whatever still moves.
[[nodiscard]] inline bool cuts_quick_stop(const Drive& drive) {
  return drive.registers().habits.cuts_quick_stop &&
         drive.state().power.machine.state() == PowerState::quick_stop_active;
}

/// Question, 5E20h:05: 6060h does not take `wanted` now. The mode that it has is no change.
[[nodiscard]] bool refuses_mode_change(const Drive& drive, OperatingMode wanted);

/// Question, 5E20h:08: 6061h does not follow 6060h yet.
[[nodiscard]] inline bool holds_mode(const Drive& drive) {
  return drive.registers().waits.mode != 0;
}

/// Question, 5E20h:0A: bit 10 shows in cyclic synchronous position that the demand stands on the
/// point that was streamed last.
[[nodiscard]] inline bool shows_points(const Drive& drive) {
  return drive.registers().habits.shows_points;
}

/// Question, 5E20h:0B: a move in profile position mode that is planned anew starts at velocity 0.
[[nodiscard]] inline bool plans_from_rest(const Drive& drive, MotionRequest::Kind kind) {
  return drive.registers().habits.plans_from_rest && kind == MotionRequest::Kind::move &&
         drive.state().mode.actual == OperatingMode::profile_position;
}

/// Question, 5E20h:0D: a homing run lasts only while bit 4 of 6040h is 1.
[[nodiscard]] inline bool homes_by_level(const Drive& drive) {
  return drive.registers().habits.homes_by_level;
}

/// Question, 5E20h:0F: halt ends a homing run for good.
[[nodiscard]] inline bool ends_homing_at_halt(const Drive& drive) {
  return drive.registers().habits.ends_homing_at_halt;
}

/// Question, 5E20h:10: transition 4 is refused, because no mode has been chosen with 6060h.
[[nodiscard]] inline bool lacks_mode(const Drive& drive) {
  return drive.registers().habits.needs_mode && drive.state().mode.wanted == OperatingMode::none;
}

}  // namespace vdrive
