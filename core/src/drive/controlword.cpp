// SPDX-License-Identifier: Apache-2.0
#include "drive/controlword.hpp"

#include "drive/faults.hpp"
#include "drive/habits.hpp"
#include "drive/mode_table.hpp"
#include "drive/power.hpp"
#include "drive/registers.hpp"

#include <utility>

namespace vdrive {
namespace {

using namespace vdrive::literals;

PowerState state_of(const Drive& drive) {
  return drive.state().power.machine.state();
}

/// Runs the power state machine with `command`.
void take_command(Drive& drive, PowerCommand command) {
  act(drive, drive.state().power.machine.command(command, power_options(drive),
                                                 reg(drive, "test_dc_link_loss"_object) == 0,
                                                 cause_present(drive)));
}

/// Takes the transitions to Switched on that Enable operation allows in the present state.
/// @return whether the drive is then in Switched on; if not, the command is handled as usual.
bool switches_on(Drive& drive) {
  const bool is_disabled = state_of(drive) == PowerState::switch_on_disabled;
  if (is_disabled && drive.registers().settings.enable_from_switch_on_disabled) {
    take_command(drive, PowerCommand::shutdown);
  }
  if (state_of(drive) == PowerState::ready_to_switch_on) {
    take_command(drive, PowerCommand::switch_on);
  }
  return state_of(drive) == PowerState::switched_on;
}

/// 5E20h:07. Enable operation takes the drive to Switched on immediately and to Operation enabled
/// after a delay.
/// @return whether the delay is running.
bool begins_power_on(Drive& drive) {
  if (!switches_on(drive)) return false;
  HabitWaits& waits = drive.registers().waits;
  if (waits.power_on == 0) begin_wait(drive, waits.power_on, drive.registers().habits.power_on);
  return true;
}

/// 5E20h:09. A pending reset is not restarted.
/// @return whether the reset is delayed.
bool begins_reset(Drive& drive) {
  if (state_of(drive) != PowerState::fault) return false;
  HabitWaits& waits = drive.registers().waits;
  if (waits.reset == 0) begin_wait(drive, waits.reset, drive.registers().habits.reset);
  return true;
}

/// @return whether a habit refuses `command` or delays it.
bool holds_back(Drive& drive, PowerCommand command) {
  const Habits& habits = drive.registers().habits;
  switch (command) {
    case PowerCommand::none:
      return false;
    case PowerCommand::enable_operation:
      if (lacks_mode(drive)) return switches_on(drive);  // and stays there
      return habits.power_on != 0 && begins_power_on(drive);
    case PowerCommand::fault_reset:
      return habits.reset != 0 && begins_reset(drive);
    default:
      drive.registers().waits.power_on = 0;  // another command cancels Enable operation
      return false;
  }
}

bool accepts(const Drive& drive) {
  return operation_enabled(drive) && drive.state().power.machine.pending() == PowerCommand::none;
}

/// Carries out a controlword that the drive has read.
void obey(Drive& drive, std::uint16_t word) {
  DriveState& s = drive.state();
  const std::uint16_t previous = std::exchange(s.controlword, word);
  const bool ready_before = accepts(drive);
  const PowerCommand command = decode_command(word, previous);
  if (!holds_back(drive, command)) take_command(drive, command);
  const bool accepting = ready_before && accepts(drive) && s.mode.wanted == s.mode.actual;
  mode_of(drive).command(drive, {.previous = previous, .accepting = accepting});
  s.plan_due = true;
  s.attention = true;
}

/// @return whether overwriting the unread word `waiting` with `next` hides an edge of bit 4.
bool hides_edge(std::uint16_t in_force, std::uint16_t waiting, std::uint16_t next) {
  const unsigned came_and_went = waiting & ~unsigned{in_force} & ~unsigned{next};
  const unsigned went_and_came = in_force & ~unsigned{waiting} & unsigned{next};
  return ((came_and_went | went_and_came) & Controlword::kNewSetPoint) != 0;
}

/// Carries out the word that has not been read yet, if there is one.
void execute_waiting(Drive& drive) {
  HabitWaits& waits = drive.registers().waits;
  if (!std::exchange(waits.has_word, false)) return;
  obey(drive, waits.word);
}

/// 5E20h:06. Only the last word before a read counts. An edge of bit 4 that no read sees is counted
/// as not accepted, so that a test notices the loss.
void defer_word(Drive& drive, std::uint16_t word) {
  DriveState& s = drive.state();
  HabitWaits& waits = drive.registers().waits;
  if (waits.has_word && hides_edge(s.controlword, waits.word, word)) ++s.ignored_set_points;
  waits.word = word;
  waits.has_word = true;
  s.power.waits = true;
  s.attention = true;
}

/// @return whether the drive reads 6040h in this tick; always true when the habit is off.
bool looks(Drive& drive) {
  const std::uint32_t loop = drive.registers().habits.loop;
  HabitWaits& waits = drive.registers().waits;
  if (loop == 0) return true;
  if (waits.look == 0 || waits.look > loop) waits.look = loop;
  --waits.look;
  return waits.look == 0;
}

/// Counts down a wait by the present tick.
/// @return whether it ends in this tick.
bool has_ended(std::uint32_t& wait) {
  if (wait == 0) return false;
  --wait;
  return wait == 0;
}

}  // namespace

void write_controlword(Drive& drive, std::uint16_t word) {
  if (drive.registers().habits.loop != 0) {
    defer_word(drive, word);
  } else {
    execute_waiting(drive);  // written before the habit was switched off
    obey(drive, word);
  }
}

void begin_held_back(Drive& drive) {
  HabitWaits& waits = drive.registers().waits;
  if (looks(drive)) execute_waiting(drive);
  if (state_of(drive) != PowerState::switched_on) {
    waits.power_on = 0;  // a fault, or the voltage is gone
  } else if (has_ended(waits.power_on) && !lacks_mode(drive)) {
    take_command(drive, PowerCommand::enable_operation);
  }
  static_cast<void>(has_ended(waits.mode));  // follow_mode reads the counter
}

void end_held_back(Drive& drive) {
  HabitWaits& waits = drive.registers().waits;
  if (has_ended(waits.reset)) {
    // Whether a cause persists is checked after the reset, not before it.
    act(drive, drive.state().power.machine.command(PowerCommand::fault_reset, power_options(drive),
                                                   true, false));
  }
  note_waits(drive);
}

}  // namespace vdrive
