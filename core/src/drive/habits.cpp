// SPDX-License-Identifier: Apache-2.0
#include "drive/habits.hpp"

#include "vdrive/cia402/statusword.hpp"

namespace vdrive {
namespace {

using namespace vdrive::literals;

bool is_on(const Drive& drive, ObjectRow row) {
  return reg(drive, row) != 0;
}

Transition16 transition_16_of(std::int64_t value) {
  switch (value) {
    case 1:
      return Transition16::always;
    case 2:
      return Transition16::never;
    default:
      return Transition16::by_option_code;
  }
}

ModeChangeRefusal mode_change_of(std::int64_t value) {
  return {.under_halt = (value & 1) != 0, .beyond_switched_on = (value & 2) != 0};
}

/// @return whether 6060h may be changed with 5E20h:05 = 2: before Operation enabled, without a
///         fault.
bool is_before_operation(PowerState state) {
  return state == PowerState::not_ready_to_switch_on || state == PowerState::switch_on_disabled ||
         state == PowerState::ready_to_switch_on || state == PowerState::switched_on;
}

}  // namespace

void update_habits(Drive& drive) noexcept {
  drive.registers().habits = {
      .loop = ticks_of_ms(drive, reg(drive, "habit_controlword_loop"_object)),
      .power_on = ticks_of_ms(drive, reg(drive, "habit_power_on_time"_object)),
      .mode = ticks_of_ms(drive, reg(drive, "habit_mode_display_delay"_object)),
      .reset = ticks_of_ms(drive, reg(drive, "habit_fault_reset_delay"_object)),
      .transition_16 = transition_16_of(reg(drive, "habit_transition_16"_object)),
      .mode_change = mode_change_of(reg(drive, "habit_mode_change_refusal"_object)),
      .acknowledges_enabling = is_on(drive, "habit_acknowledge_at_enabling"_object),
      .gates_stream = is_on(drive, "habit_stream_release_bits"_object),
      .cuts_quick_stop = is_on(drive, "habit_short_quick_stop"_object),
      .shows_points = is_on(drive, "habit_stream_target_bit"_object),
      .plans_from_rest = is_on(drive, "habit_plan_from_rest"_object),
      .homes_by_level = is_on(drive, "habit_homing_by_level"_object),
      .clears_velocity = is_on(drive, "habit_clear_target_velocity"_object),
      .ends_homing_at_halt = is_on(drive, "habit_homing_ends_at_halt"_object),
      .needs_mode = is_on(drive, "habit_mode_before_enabling"_object)};
  DriveState& s = drive.state();
  s.manufacturer_bits = static_cast<std::uint16_t>(
      Statusword::kRemote ^ unsigned_reg(drive, "habit_statusword_bits"_object));
  s.attention = true;
  note_waits(drive);
}

void begin_operation(Drive& drive) {
  const Habits& habits = drive.registers().habits;
  drive.state().modes.position.acknowledges_enabling = habits.acknowledges_enabling;
  if (!habits.clears_velocity) return;
  drive.registers().values["target_velocity"_object] = 0;
  drive.registers().values["vl_target_velocity"_object] = 0;
}

bool refuses_mode_change(const Drive& drive, OperatingMode wanted) {
  const DriveState& s = drive.state();
  const ModeChangeRefusal& refusal = drive.registers().habits.mode_change;
  if (wanted == s.mode.wanted) return false;
  return (refusal.under_halt && halted(drive)) ||
         (refusal.beyond_switched_on && !is_before_operation(s.power.machine.state()));
}

}  // namespace vdrive
