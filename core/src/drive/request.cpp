// SPDX-License-Identifier: Apache-2.0
#include "drive/request.hpp"

#include "drive/homing.hpp"
#include "drive/registers.hpp"
#include "drive/rounding.hpp"

#include <algorithm>
#include <cmath>

namespace vdrive {
namespace {

using namespace vdrive::literals;
using Kind = MotionRequest::Kind;

/// Value of a ramp object within the cap of 60C5h or 60C6h; 0 counts as 1.
double within(const DriveContext& axis, ObjectRow ramp, ObjectRow cap) {
  return std::min(std::max(real(axis, ramp), 1.0), std::max(real(axis, cap), 1.0));
}

double acceleration_of(const DriveContext& axis, ObjectRow row) {
  return within(axis, row, "app_acc_limit"_object);
}

double deceleration_of(const DriveContext& axis, ObjectRow row) {
  return within(axis, row, "app_dec_limit"_object);
}

/// The normal ramp: 609Ah in homing, 6084h elsewhere.
double normal_deceleration(const DriveContext& axis) {
  return deceleration_of(axis, axis.state.mode.actual == OperatingMode::homing
                                   ? "homing_acceleration"_object
                                   : "profile_dec"_object);
}

MotionRequest stop_with(double deceleration) {
  return {.kind = Kind::stop,
          .target = 0.0,
          .limits = {.velocity = 0.0, .acceleration = 1.0, .deceleration = deceleration}};
}

/// `torque` [‰ of rated] within 6072h, 60E0h and 60E1h: a ramp beyond what is ever commanded would
/// have to come all the way back before it is felt.
double within_torque_limits(const DriveContext& axis, double torque) {
  const DriveState& s = axis.state;
  const double highest = real(axis, "max_torque"_object);
  const double unit = std::min(s.units.torque_per_mille / s.units.current_per_mille, 1.0);
  const auto limit = [&axis, highest, unit](ObjectRow row) {
    const double relative = real(axis, row);
    return relative == 0.0 ? highest : std::min(highest, relative * unit);
  };
  return std::min(std::max(torque, -limit("negative_torque_limit_relative"_object)),
                  limit("positive_torque_limit_relative"_object));
}

/// 6071h by the slope 6087h; 0 counts as 1.
MotionRequest torque_to(const DriveContext& axis, double target) {
  return {.kind = Kind::torque,
          .target = within_torque_limits(axis, target),
          .limits = {.velocity = 0.0,
                     .acceleration = std::max(real(axis, "torque_slope"_object), 1.0),
                     .deceleration = 1.0}};
}

/// The normal ramp as a stop: profile torque takes the torque back, the other modes the speed.
MotionRequest normal_stop(const DriveContext& axis) {
  return axis.state.mode.actual == OperatingMode::profile_torque
             ? torque_to(axis, 0.0)
             : stop_with(normal_deceleration(axis));
}

/// Option codes 605Ah, 605Dh, 605Eh: 1 normal ramp, 2 quick ramp, 3 and 4 the steepest there is.
double option_deceleration(const DriveContext& axis, std::int64_t option) {
  switch (option) {
    case 1:
      return normal_deceleration(axis);
    case 2:
      return deceleration_of(axis, "quick_stop_deceleration"_object);
    default:
      return deceleration_of(axis, "app_dec_limit"_object);
  }
}

MotionRequest stop_by_option(const DriveContext& axis, std::int64_t option) {
  return option == 1 ? normal_stop(axis) : stop_with(option_deceleration(axis, option));
}

MotionRequest limit_switch_stop(const DriveContext& axis) {
  return stop_with(deceleration_of(axis, "quick_stop_deceleration"_object));
}

/// @return whether a limit switch is active in the direction of `motion`.
bool runs_into_limit_switch(const DriveContext& axis, double motion) {
  const std::uint8_t inputs = axis.state.limits.inputs;
  return ((inputs & kPositiveLimitInput) != 0 && motion > 0.0) ||
         ((inputs & kNegativeLimitInput) != 0 && motion < 0.0);
}

/// A limit switch stops what runs into it. A target on its far side is given up for good: bit 10
/// stays 0 until a new set-point; one on the near side is approached after the stop.
bool stopped_by_limit_switch(const DriveContext& axis) {
  DriveState& s = axis.state;
  const double ahead = s.target.given ? s.target.position - s.demand.position : 0.0;
  if (runs_into_limit_switch(axis, ahead)) {
    s.set_points.queue.drop_buffered(
        s.controlword);  // a master waits for bit 12 before it drops bit 4
    s.target.given = false;
    s.set_points.active = false;
    s.target.given_up = true;
  }
  return runs_into_limit_switch(axis, s.demand.velocity);
}

/// From rest the plan of the common times; after a halt what is left, with the same ramps and the
/// same peak, so that axes which halt and go on together stay on their line.
MotionRequest synchronous_move(const DriveContext& axis) {
  const DriveRegisters& r = axis.registers;
  const bool planned = r.set_point.starts || r.request.kind == Kind::synchronous_move;
  return {.kind = planned ? Kind::synchronous_move : Kind::move,
          .target = axis.state.target.position,
          .limits = r.set_point.limits};
}

MotionRequest profile_position(const DriveContext& axis) {
  const DriveState& s = axis.state;
  if (stopped_by_limit_switch(axis)) {
    return limit_switch_stop(axis);
  }
  const DriveRegisters& r = axis.registers;
  const bool synchronous = s.target.given && r.set_point.times.duration > 0.0;
  if (halted(axis)) {
    const std::int64_t option = reg(axis, "halt_option_code"_object);
    return synchronous && option == 1 ? stop_with(r.set_point.limits.deceleration)
                                      : stop_by_option(axis, option);
  }
  if (synchronous) {
    return synchronous_move(axis);
  }
  if (!s.target.given) {
    return s.target.given_up ? limit_switch_stop(axis) : normal_stop(axis);
  }
  return {.kind = Kind::move,
          .target = s.target.position,
          .limits = {.velocity = std::min(r.set_point.velocity, r.velocity_cap),
                     .acceleration = acceleration_of(axis, "profile_acc"_object),
                     .deceleration = deceleration_of(axis, "profile_dec"_object)}};
}

/// A target that runs into a limit switch is given up for good: a new one has to be written.
MotionRequest profile_velocity(const DriveContext& axis) {
  DriveState& s = axis.state;
  const double target = real(axis, "target_velocity"_object);
  MotionRequest request{.kind = Kind::velocity,
                        .target = target,
                        .limits = {.velocity = axis.registers.velocity_cap,
                                   .acceleration = acceleration_of(axis, "profile_acc"_object),
                                   .deceleration = deceleration_of(axis, "profile_dec"_object)}};
  if (halted(axis)) {
    request.target = 0.0;
    request.limits.deceleration = option_deceleration(axis, reg(axis, "halt_option_code"_object));
  }
  s.target.given_up = s.target.given_up || runs_into_limit_switch(axis, target);
  if (s.target.given_up) {
    request.target = 0.0;
  }
  if (s.target.given_up || runs_into_limit_switch(axis, s.demand.velocity)) {
    request.limits.deceleration = deceleration_of(axis, "quick_stop_deceleration"_object);
  }
  return request;
}

/// A limit switch is stronger than halt, and holds the axis until a new torque is written, unless
/// the present one leads away from it.
MotionRequest profile_torque(const DriveContext& axis) {
  DriveState& s = axis.state;
  const double target = real(axis, "target_torque"_object);
  const double speed = axis.servo.load_speed[axis.lane];
  const double running = std::abs(speed) > static_cast<double>(s.window.threshold) ? speed : 0.0;
  const bool runs_in = runs_into_limit_switch(axis, running);
  s.target.given_up =
      s.target.given_up || runs_into_limit_switch(axis, target) || (runs_in && target == 0.0);
  if (s.target.given_up || runs_in) {
    return limit_switch_stop(axis);
  }
  if (halted(axis)) {
    return stop_by_option(axis, reg(axis, "halt_option_code"_object));
  }
  return torque_to(axis, target);
}

MotionRequest homing(const DriveContext& axis) {
  const DriveState& s = axis.state;
  if (halted(axis)) {
    return stop_by_option(axis, reg(axis, "halt_option_code"_object));
  }
  const bool searches = s.homing.stage == HomingStage::search;
  const double speed =
      std::min(real(axis, searches ? "homing_speed_search"_object : "homing_speed_creep"_object),
               axis.registers.velocity_cap);
  MotionRequest request{
      .kind = Kind::velocity,
      .target = homing_direction(axis) * speed,
      .limits = {.velocity = speed,
                 .acceleration = acceleration_of(axis, "homing_acceleration"_object),
                 .deceleration = deceleration_of(axis, "homing_acceleration"_object)}};
  switch (s.homing.stage) {
    case HomingStage::search:
    case HomingStage::leave:
    case HomingStage::index:
      return request;
    case HomingStage::back:
    case HomingStage::done:
      request.kind = Kind::move;
      request.target = s.target.position;
      return request;
    default:
      return normal_stop(axis);
  }
}

/// The streamed position, by the shorter way round the register; with software limits between them.
/// A target behind a limit switch is given up: the next one that is written counts.
MotionRequest cyclic_synchronous_position(const DriveContext& axis) {
  DriveState& s = axis.state;
  if (!s.cyclic.streams) {
    return s.target.given_up ? limit_switch_stop(axis) : normal_stop(axis);
  }
  const double streamed = real(axis, "position_user_target_value"_object);
  const double goal = clamp_to_software_limits(axis, streamed);
  const double whole = nearest(s.demand.position);
  const double target = whole + (s.limits.enabled ? goal - wrapped(whole)
                                                  : static_cast<double>(wrapped(goal - whole)));
  s.target.given_up = runs_into_limit_switch(axis, target - s.demand.position);
  s.cyclic.streams = !s.target.given_up;
  if (s.target.given_up || runs_into_limit_switch(axis, s.demand.velocity)) {
    return limit_switch_stop(axis);
  }
  return {.kind = Kind::follow,
          .target = target,
          .limits = {
              .velocity = axis.registers.velocity_cap, .acceleration = 1.0, .deceleration = 1.0}};
}

MotionRequest request_in_operation(const DriveContext& axis) {
  const DriveState& s = axis.state;
  if (s.mode.wanted != s.mode.actual) {
    return runs_into_limit_switch(axis, s.demand.velocity) ? limit_switch_stop(axis)
                                                           : stop_with(normal_deceleration(axis));
  }
  if (s.power.machine.pending() != PowerCommand::none) {
    return normal_stop(axis);
  }
  switch (s.mode.actual) {
    case OperatingMode::profile_position:
      return profile_position(axis);
    case OperatingMode::profile_velocity:
      return profile_velocity(axis);
    case OperatingMode::profile_torque:
      return profile_torque(axis);
    case OperatingMode::homing:
      return homing(axis);
    case OperatingMode::cyclic_synchronous_position:
      return cyclic_synchronous_position(axis);
    default:
      return runs_into_limit_switch(axis, s.demand.velocity) ? limit_switch_stop(axis)
                                                             : normal_stop(axis);
  }
}

}  // namespace

MotionRequest requested_motion(const DriveContext& axis) {
  if (!axis.state.power.on) {
    return {};
  }
  switch (axis.state.power.machine.state()) {
    case PowerState::operation_enabled:
      return request_in_operation(axis);
    case PowerState::quick_stop_active: {
      const std::int64_t option = reg(axis, "quick_stop_option_code"_object);
      return stop_by_option(axis, option > 4 ? option - 4 : option);
    }
    case PowerState::fault_reaction_active:
      return stop_by_option(axis, reg(axis, "fault_reaction_option_code"_object));
    default:
      return {};
  }
}

Control control_of(const DriveContext& axis, const MotionRequest& request) {
  if (request.kind == Kind::torque) {
    return Control::torque;
  }
  const bool by_velocity =
      request.kind == Kind::velocity && axis.state.mode.actual == OperatingMode::profile_velocity;
  return by_velocity ? Control::velocity : Control::position;
}

}  // namespace vdrive
