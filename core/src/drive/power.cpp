// SPDX-License-Identifier: Apache-2.0
#include "drive/power.hpp"

#include "drive/faults.hpp"
#include "drive/frame.hpp"
#include "drive/habits.hpp"
#include "drive/registers.hpp"
#include "drive/target.hpp"
#include "drive/touch_probe.hpp"
#include "drive/window.hpp"

#include <algorithm>
#include <cstddef>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// Longest wait for standstill after the demand of a stop has ended. A load pushed from outside may
/// never stand still.
constexpr std::uint32_t kLongestStandstillWait_us = 1'000'000;

/// Switches the power stage on or off. Without power the demand follows the actual position.
void set_power(Drive& drive, bool powered) {
  drive.state().power.on = powered;
  drive.servo().powered[drive.lane()] = powered ? 1.0 : 0.0;
  drive.servo().integrator[drive.lane()] = 0.0;
  drive.registers().torque_offset = 0.0;
  drive.state().demand.control = ControlLoop::position;
  drive.servo().closes_position[drive.lane()] = 1.0;
  drive.servo().torque_control[drive.lane()] = 0.0;
  if (!powered) {
    drive.servo().torque[drive.lane()] = 0.0;
    rest_at(drive, actual_position(drive));
  }
}

/// Takes control of the axis at its present position, without set-points.
void take_control(Drive& drive) {
  rebase(drive);
  rest_at(drive, actual_position(drive));
  set_power(drive, true);
  drive.registers().request = {};
  drive.state().following_error.count = 0;
  seed_target(drive);
}

/// Transition 4: 607Fh and 6080h take effect, set-points are cleared.
void enable(Drive& drive) {
  drive.registers().speed_limits = {
      .app_speed_limit = real(drive, "app_speed_limit"_object),
      .motor_max_speed_rpm = real(drive, "motor_max_speed_rpm"_object)};
  update_velocity_cap(drive);
  take_control(drive);
  begin_operation(drive);
}

/// Transition 16: the interrupted move is dropped; a motion still in progress is stopped.
void re_enable(Drive& drive) {
  if (!drive.state().power.on) {  // 605Ah was 0 when the quick stop began: the axis coasts
    take_control(drive);
  } else if (drive.state().demand.moving) {
    drop_targets(drive);
    // A mode change during the quick stop may have taken the demand as the target.
    drive.state().target.arrived = false;
    drive.state().window.dwell = 0;
  } else {
    seed_target(drive);
  }
}

bool has_power_to_lose(PowerState state) {
  return state == PowerState::operation_enabled || state == PowerState::quick_stop_active ||
         state == PowerState::fault_reaction_active;
}

/// Raises the fault of a cause that is present. Loss of the DC link is a fault only if the motor is
/// powered; otherwise the drive falls back to Switch on disabled. If a cause was cleared for a
/// reset and returned before the tick, that is a new fault.
void raise_cause(Drive& drive, std::uint8_t bit, ErrorCode code) {
  const DriveState& s = drive.state();
  const bool known = (s.faults.causes & bit) != 0 && is_fault(s.power.machine.state());
  const bool harmless = bit == kDcLinkCause && !has_power_to_lose(s.power.machine.state());
  if (!known && !harmless) raise_fault(drive, code);
}

/// @return whether there is a motion to end or a torque to remove. A torque that presses against a
///         load causes no motion.
bool has_demand(const Drive& drive) {
  const DemandState& demand = drive.state().demand;
  return demand.moving || (demand.control == ControlLoop::torque && demand.torque != 0.0);
}

/// Counts the present tick of a stop.
/// @return whether the state may end: the axis stands, or kLongestStandstillWait_us is over.
bool stop_has_ended(Drive& drive) {
  DriveState& s = drive.state();
  const DriveRegisters& r = drive.registers();
  if (s.power.on && has_demand(drive)) {
    s.power.stop_ticks = 0;
    return false;
  }
  const std::uint32_t longest = kLongestStandstillWait_us / drive.timing().period_us;
  if (s.power.on && !at_rest(drive) && ++s.power.stop_ticks < longest) return false;
  const bool dwells = s.power.machine.state() == PowerState::quick_stop_active &&
                      s.power.ticks_in_state < ticks_of_ms(drive, r.settings.quick_stop_dwell_ms);
  return !dwells;
}

}  // namespace

PowerOptions power_options(const Drive& drive) {
  return {
      .quick_stop_option_code =
          static_cast<std::int8_t>(reg(drive, "quick_stop_option_code"_object)),
      .shutdown_option_code = static_cast<std::int8_t>(reg(drive, "shutdown_option_code"_object)),
      .disable_operation_option_code =
          static_cast<std::int8_t>(reg(drive, "disable_operation_option_code"_object)),
      .enable_from_switch_on_disabled = drive.registers().settings.enable_from_switch_on_disabled,
      .transition_16 = drive.registers().habits.transition_16};
}

void act(Drive& drive, const TransitionSet& taken) {
  if (taken.empty()) return;
  DriveState& s = drive.state();
  s.power.ticks_in_state = 0;
  s.attention = true;
  s.plan_due = true;
  s.power.stop_ticks = 0;
  if (taken.contains(4)) {
    enable(drive);
  } else if (taken.contains(16)) {
    re_enable(drive);
  } else if (taken.contains(11)) {
    drop_targets(drive);
    if (reg(drive, "quick_stop_option_code"_object) == 0) set_power(drive, false);
  } else if (taken.contains(13)) {
    drop_targets(drive);
    if (s.faults.coasting || reg(drive, "fault_reaction_option_code"_object) == 0) {
      set_power(drive, false);
    }
  } else {
    drop_targets(drive);
    set_power(drive, false);
  }
  if (taken.contains(15)) clear_fault(drive);
}

void raise_fault(Drive& drive, ErrorCode code) {
  DriveState& s = drive.state();
  enter_fault(drive, code);
  s.faults.coasting = s.faults.coasting || forces_coasting(code);
  act(drive, s.power.machine.fault_detected());
  if (s.faults.coasting && s.power.on) {
    set_power(drive, false);  // the axis was braking but can no longer brake
  }
}

void watch_causes(Drive& drive) {
  DriveState& s = drive.state();
  std::uint8_t present = 0;
  for (const FaultCause& cause : kFaultCauses) {
    if (reg(drive, cause.input) == 0) continue;
    present = static_cast<std::uint8_t>(present | cause.bit);
    raise_cause(drive, cause.bit, cause.code);
  }
  if (s.faults.load_level == LoadLevel::fault) {
    present = static_cast<std::uint8_t>(present | kLoadLevelCause);
    raise_cause(drive, kLoadLevelCause, ErrorCode::load_level);
  }
  s.faults.causes = present;
  s.faults.dc_link = (present & kDcLinkCause) == 0;
  if (!s.faults.dc_link) act(drive, s.power.machine.voltage_lost());
}

void complete_stops(Drive& drive) {
  DriveState& s = drive.state();
  const bool stopping = s.power.machine.state() == PowerState::quick_stop_active ||
                        s.power.machine.state() == PowerState::fault_reaction_active ||
                        s.power.machine.pending() != PowerCommand::none;
  if (!stopping || s.power.ticks_in_state == 0) return;
  if (cuts_quick_stop(drive) || stop_has_ended(drive)) {
    act(drive, s.power.machine.stop_finished(power_options(drive)));
  }
}

void power_up(Drive& drive, bool initialise) noexcept {
  DriveRegisters& r = drive.registers();
  for (std::size_t row = 0; row < kObjectCount; ++row) {
    // Inputs of the test bench are not part of the drive, so they outlast a power cycle.
    const ObjectDescription& object = kObjectRows[row];
    if (object.role != Role::test_input) r.values[row] = object.default_value;
  }
  drive.state() = {};
  r.request = {};
  r.waits = {};
  r.record_buffer.count = 0;
  forget_touch_probes(drive);
  clear_history(drive);
  set_power(drive, false);
  update_derived(drive);
  update_habits(drive);
  if (initialise) complete_power_up(drive);
}

void complete_power_up(Drive& drive) {
  const TransitionSet taken = drive.state().power.machine.initialised();
  act(drive, taken);
  if (taken.contains(1) && drive.registers().memory_error) {
    raise_fault(drive, ErrorCode::parameter_memory);
  }
}

void lose_connection(Drive& drive) noexcept {
  DriveState& s = drive.state();
  const std::int64_t option = reg(drive, "abort_connection_option_code"_object);
  if (option != 0) forget_commands(drive);
  const PowerState state = s.power.machine.state();
  if (state != PowerState::operation_enabled && state != PowerState::quick_stop_active) return;
  switch (option) {
    case 1:
      raise_fault(drive, ErrorCode::life_guard_or_heartbeat);
      break;
    case 2:
      act(drive, s.power.machine.command(PowerCommand::disable_voltage, power_options(drive), true,
                                         false));
      break;
    case 3:
      act(drive,
          s.power.machine.command(PowerCommand::quick_stop, power_options(drive), true, false));
      break;
    default:
      break;
  }
}

void drop_power(Drive& drive) noexcept {
  act(drive, drive.state().power.machine.power_dropped());
}

}  // namespace vdrive
