// SPDX-License-Identifier: Apache-2.0
#include "drive/drive.hpp"

#include "drive/demand.hpp"
#include "drive/homing.hpp"
#include "drive/monitor.hpp"
#include "drive/power.hpp"
#include "drive/registers.hpp"
#include "drive/rounding.hpp"

#include <cmath>

namespace vdrive {
namespace {

using namespace vdrive::literals;

/// Modes whose demand depends on more than writes: it is looked at in every tick.
bool evolves(const DriveState& s) {
  switch (s.mode.actual) {
    case OperatingMode::profile_torque:
    case OperatingMode::cyclic_synchronous_position:
      return s.power.on;
    case OperatingMode::homing:
      return homing_runs(s.homing.stage);
    default:
      return false;
  }
}

bool needs_attention(const DriveContext& axis) {
  const DriveState& s = axis.state;
  const PowerState state = s.power.machine.state();
  return state == PowerState::not_ready_to_switch_on || state == PowerState::quick_stop_active ||
         state == PowerState::fault_reaction_active ||
         s.power.machine.pending() != PowerCommand::none || axis.state.faults.causes != 0 ||
         (s.limits.inputs & (kNegativeLimitInput | kPositiveLimitInput)) != 0 ||
         s.mode.wanted != s.mode.actual || evolves(s);
}

bool is_test_bench_input(const ObjectDescription& object) {
  return object.address.index >= 0x5E00 && object.address.index <= 0x5E09;
}

/// Transition 1, unless it is done already. What the memory check found is a fault from there on.
void complete_power_up(const DriveContext& axis) {
  const TransitionSet taken = axis.state.power.machine.initialised();
  act(axis, taken);
  if (taken.contains(1) && axis.registers.memory_error) {
    raise_fault(axis, ErrorCode::parameter_memory);
  }
}

}  // namespace

void power_up(const DriveContext& axis, bool initialise) noexcept {
  DriveRegisters& r = axis.registers;
  for (std::size_t row = 0; row < kObjectCount; ++row) {
    // The test bench is not the drive: what it does to the axis outlasts a power cycle.
    if (!is_test_bench_input(kObjectTable[row])) {
      r.values[row] = kObjectTable[row].default_value;
    }
  }
  const DriveState& before = axis.state;
  DriveState fresh;
  fresh.units.torque_per_mille = before.units.torque_per_mille;
  fresh.units.current_per_mille = before.units.current_per_mille;
  axis.state = fresh;
  r.request = {};
  r.history.codes = {};
  r.history.count = 0;
  set_power(axis, false);
  update_derived(axis);
  if (initialise) {
    complete_power_up(axis);
  }
}

void lose_connection(const DriveContext& axis) noexcept {
  DriveState& s = axis.state;
  const PowerState state = s.power.machine.state();
  if (state != PowerState::operation_enabled && state != PowerState::quick_stop_active) {
    return;
  }
  switch (reg(axis, "abort_connection_option_code"_object)) {
    case 1:
      raise_fault(axis, ErrorCode::life_guard_or_heartbeat);
      break;
    case 2:
      act(axis,
          s.power.machine.command(PowerCommand::disable_voltage, power_options(axis), true, false));
      break;
    case 3:
      act(axis,
          s.power.machine.command(PowerCommand::quick_stop, power_options(axis), true, false));
      break;
    default:
      break;
  }
}

TickStart begin_tick(const DriveContext& axis, DemandBlock& demand) noexcept {
  DriveState& s = axis.state;
  if (std::abs(s.demand.position) > kFrame) {
    rebase(axis);
    axis.registers.request = {};
    s.plan_due = true;
  }
  if (s.attention) {
    complete_power_up(axis);
    complete_stops(axis);
    watch_causes(axis);
    follow_mode(axis);
    advance_homing(axis);
    s.plan_due = true;
  }
  if (s.plan_due) {
    replan(axis);
  }
  const std::size_t l = axis.lane;
  demand.position[l] = s.demand.segment.position;
  demand.velocity[l] = s.demand.segment.velocity;
  demand.acceleration[l] = s.demand.segment.acceleration;
  demand.reference_time[l] = s.demand.segment.reference_time;
  demand.first_substep[l] = s.demand.plan_ticks * axis.timing.substeps;
  const double last_time =
      (demand.first_substep[l] + (axis.timing.substeps - 1.0)) * axis.timing.substep;
  return {.across = last_time >= s.demand.segment.end_time,
          .general = s.demand.control != Control::position};
}

void sample_across(const DriveContext& axis, DemandBlock& demand) noexcept {
  const std::size_t l = axis.lane;
  for (std::size_t k = 0; k < axis.timing.substeps; ++k) {
    const double time = (demand.first_substep[l] + static_cast<double>(k)) * axis.timing.substep;
    const MotionSample now = axis.registers.profile.at(time);
    demand.positions[k][l] = now.position;
    demand.velocities[k][l] = now.velocity;
    demand.accelerations[k][l] = now.acceleration;
  }
}

void end_tick(const DriveContext& axis) noexcept {
  DriveState& s = axis.state;
  advance_demand(axis);
  const double demand = nearest(s.demand.position);
  const double actual = nearest(axis.servo.load_reading[axis.lane]);
  watch_following_error(axis, demand - actual);
  compose_statusword(axis, demand, actual);
  fill_status(axis);
  s.target.fresh = false;
  if (s.power.ticks_in_state != kSaturatedCount) {
    ++s.power.ticks_in_state;
  }
  s.attention = needs_attention(axis);
}

void refresh_status(const DriveContext& axis) noexcept {
  compose_statusword(axis, nearest(axis.state.demand.position),
                     nearest(axis.servo.load_reading[axis.lane]));
  fill_status(axis);
}

}  // namespace vdrive
