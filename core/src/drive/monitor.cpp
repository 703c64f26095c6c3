// SPDX-License-Identifier: Apache-2.0
#include "drive/monitor.hpp"

#include "drive/demand.hpp"
#include "drive/power.hpp"
#include "drive/registers.hpp"
#include "drive/rounding.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <cmath>

namespace vdrive {
namespace {

using namespace vdrive::literals;

std::uint16_t reached_when(bool reached) {
  return reached ? Statusword::kTargetReached : 0U;
}

/// Counts ticks in a row for which `inside` held.
/// @return whether it has held for more than `ticks`.
bool has_lasted(bool inside, std::uint32_t& count, std::uint32_t ticks) {
  if (!inside) {
    count = 0;
  } else if (count != kSaturatedCount) {
    ++count;
  }
  return count > ticks;
}

/// The demand rests on the target and the actual position was inside the window for the window
/// time.
bool watch_target(const DriveContext& axis, double actual) {
  DriveState& s = axis.state;
  const bool inside = s.window.position == kWindowOff || std::abs(actual - s.target.position) <=
                                                             static_cast<double>(s.window.position);
  const bool lasted = has_lasted(inside, s.window.dwell, s.window.position_ticks);
  return s.target.arrived && !s.target.fresh && (s.window.position == kWindowOff || lasted);
}

std::uint16_t profile_position_bits(const DriveContext& axis, double actual) {
  DriveState& s = axis.state;
  bool reached = watch_target(axis, actual);
  if (reached && !halted(axis)) {
    s.set_points.active = false;
    SetPoint next;
    if (s.set_points.queue.take_buffered(s.controlword, next)) {
      if (can_start(axis, next)) {
        start_set_point(axis, next);
        reached = false;
      } else {
        ++s.ignored_set_points;
      }
    }
  }
  return static_cast<std::uint16_t>(
      reached_when(halted(axis) ? at_rest(axis) : reached) |
      (s.set_points.queue.acknowledge() ? Statusword::kSetPointAcknowledge : 0U));
}

/// Bit 10 by 606Dh and 606Eh, under halt at standstill; bit 12 by 606Fh and 6070h.
std::uint16_t profile_velocity_bits(const DriveContext& axis) {
  DriveState& s = axis.state;
  const double speed = nearest(axis.servo.load_speed[axis.lane]);
  const double error = std::abs(real(axis, "target_velocity"_object) - speed);
  const bool reached =
      has_lasted(error <= s.window.velocity, s.window.dwell, s.window.velocity_ticks);
  const bool standing = has_lasted(std::abs(speed) <= s.window.threshold, s.window.standstill,
                                   s.window.threshold_ticks);
  return static_cast<std::uint16_t>(reached_when(halted(axis) ? at_rest(axis) : reached) |
                                    (standing ? Statusword::kSpeedZero : 0U));
}

/// Bit 10: the torque command has arrived at 6071h; neither a limit nor a stop keeps it away.
std::uint16_t profile_torque_bits(const DriveContext& axis) {
  const DriveState& s = axis.state;
  if (halted(axis)) {
    return reached_when(at_rest(axis));
  }
  const double torque = axis.servo.command[axis.lane] * s.units.torque_per_mille;
  return reached_when(s.demand.control == Control::torque && !s.demand.moving &&
                      nearest(torque) == real(axis, "target_torque"_object));
}

/// Bits 10, 12 and 13 of homing.
std::uint16_t homing_bits(const DriveContext& axis, double actual) {
  DriveState& s = axis.state;
  switch (s.homing.stage) {
    case HomingStage::idle:
      return reached_when(!s.demand.moving);  // a load that is pushed does not look like a run
    case HomingStage::failed:
      return static_cast<std::uint16_t>(reached_when(at_rest(axis)) | Statusword::kHomingError);
    case HomingStage::back:
    case HomingStage::done: {
      const bool reached = watch_target(axis, actual);
      if (reached) {
        s.homing.stage = HomingStage::done;
      }
      return static_cast<std::uint16_t>(reached_when(reached) | Statusword::kHomingAttained);
    }
    default:
      return 0;
  }
}

/// The demand is the streamed position: neither a stop nor a limit keeps it away.
bool follows_command(const DriveContext& axis) {
  return axis.state.demand.following &&
         wrapped(axis.state.target.position) == reg(axis, "position_user_target_value"_object);
}

/// @return bits 10 and 12, in homing 13 too.
std::uint16_t motion_bits(const DriveContext& axis, double actual) {
  const DriveState& s = axis.state;
  if (s.power.machine.state() == PowerState::quick_stop_active) {
    return reached_when(at_rest(axis));
  }
  if (!operation_enabled(axis)) {
    return 0;
  }
  switch (s.mode.actual) {
    case OperatingMode::profile_position:
      return profile_position_bits(axis, actual);
    case OperatingMode::profile_velocity:
      return profile_velocity_bits(axis);
    case OperatingMode::profile_torque:
      return profile_torque_bits(axis);
    case OperatingMode::homing:
      return homing_bits(axis, actual);
    case OperatingMode::cyclic_synchronous_position:
      return follows_command(axis) ? Statusword::kFollowsCommand : 0U;
    default:
      return 0;
  }
}

/// @return bit 11 at or beyond a software limit or on a limit switch, bit 7 strictly beyond.
std::uint16_t limit_bits(const DriveContext& axis, double internal_demand, double internal_actual) {
  const DriveState& s = axis.state;
  unsigned bits = 0;
  if ((s.limits.inputs & (kNegativeLimitInput | kPositiveLimitInput)) != 0) {
    bits |= Statusword::kInternalLimitActive;
  }
  if (s.limits.enabled) {
    const double demand = wrapped(internal_demand);
    const double actual = wrapped(internal_actual);
    if (std::min(demand, actual) <= s.limits.lower || std::max(demand, actual) >= s.limits.upper) {
      bits |= Statusword::kInternalLimitActive;
    }
    if (actual < s.limits.lower || actual > s.limits.upper) {
      bits |= Statusword::kWarning;
    }
  }
  return static_cast<std::uint16_t>(bits);
}

}  // namespace

void watch_following_error(const DriveContext& axis, double error) {
  DriveState& s = axis.state;
  const PowerState state = s.power.machine.state();
  const bool watched =
      s.power.on && s.demand.control == Control::position &&
      s.following_error.window != kWindowOff &&
      (state == PowerState::operation_enabled || state == PowerState::quick_stop_active);
  const bool outside = watched && std::abs(error) > static_cast<double>(s.following_error.window);
  if (!outside) {
    s.following_error.count = 0;
    if (s.following_error.shown && !axis.registers.settings.following_error_is_fault) {
      s.following_error.shown = false;
    }
    return;
  }
  if (s.following_error.count != kSaturatedCount) {
    ++s.following_error.count;
  }
  // The first tick outside starts the time: it has lasted longer than n ticks with the n + 2nd.
  if (s.following_error.count <= s.following_error.ticks + 1U || s.following_error.shown) {
    return;
  }
  s.following_error.shown = true;
  if (axis.registers.settings.following_error_is_fault) {
    raise_fault(axis, ErrorCode::following_error);
  }
}

void compose_statusword(const DriveContext& axis, double demand, double actual) {
  DriveState& s = axis.state;
  const std::uint16_t motion = motion_bits(axis, actual);
  unsigned word = statusword_of(s.power.machine.state()) | Statusword::kRemote | motion;
  word |= limit_bits(axis, demand, actual);
  // Before transition 1 nothing is known of the DC link yet: 0200h.
  if (s.faults.dc_link && s.power.machine.state() != PowerState::not_ready_to_switch_on) {
    word |= Statusword::kVoltageEnabled;
  }
  if (s.following_error.shown) {
    word |= Statusword::kFollowingError;
  }
  axis.status.ds402_statusword = static_cast<std::uint16_t>(word);
}

void fill_status(const DriveContext& axis) {
  const DriveState& s = axis.state;
  const ServoState& servo = axis.servo;
  const std::size_t l = axis.lane;
  AxisStatus& out = axis.status;
  const double demand = nearest(s.demand.position);
  const double load = nearest(servo.load_reading[l]);
  const double motor = nearest(servo.motor_reading[l]);
  const double demand_velocity = nearest(s.demand.velocity);
  const double load_velocity = nearest(servo.load_speed[l]);
  const double motor_velocity = nearest(servo.motor_speed[l]);
  out.position_demand_value = wrapped(demand);
  out.load_position_actual_value = wrapped(load);
  out.load_position_error_value = wrapped(demand - load);
  out.motor_position_actual_value = wrapped(motor);
  out.motor_position_error_value = wrapped(demand - motor);
  out.velocity_demand_value = saturated(demand_velocity);
  out.load_velocity_actual_value = saturated(load_velocity);
  out.load_velocity_error_value = saturated(demand_velocity - load_velocity);
  out.motor_velocity_actual_value = saturated(motor_velocity);
  out.motor_velocity_error_value = saturated(demand_velocity - motor_velocity);
  out.torque_demand = saturated16(servo.command[l] * s.units.torque_per_mille);
  out.torque_actual_value = saturated16(servo.torque[l] * s.units.torque_per_mille);
  out.current_actual_value = saturated16(servo.torque[l] * s.units.current_per_mille);
  out.current_error_value =
      saturated(static_cast<double>(out.torque_demand - out.current_actual_value) *
                s.units.rated_current / 1000.0);
  out.ds402_controlword = s.controlword;
  out.error_code = s.faults.error_code;
  out.error_register = s.faults.error_register;
  out.op_mode_actual = static_cast<std::int8_t>(s.mode.actual);
  out.motor_op_status = s.power.on ? 1 : 0;
  out.digital_inputs = s.limits.inputs;
  out.ignored_set_points = s.ignored_set_points;
  out.fault_count = s.faults.count;
}

}  // namespace vdrive
