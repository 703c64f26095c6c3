// SPDX-License-Identifier: Apache-2.0
#include "drive/demand.hpp"

#include "drive/homing.hpp"
#include "drive/registers.hpp"
#include "drive/request.hpp"
#include "drive/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdrive {
namespace {

using namespace vdrive::literals;
using Kind = MotionRequest::Kind;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRange = 4294967296.0;  // of a 32-bit position register

/// Turns of the register that lie between `position` and what the register shows of it.
double whole_turns(double position) {
  return kRange * floor_of(nearest(position) / kRange + 0.5);
}

/// 60F2h: what a relative set-point counts from (bits 0 and 1).
double relative_base(const DriveContext& axis) {
  switch (reg(axis, "positioning_option_code"_object)) {
    case 0:
      return axis.state.target;
    case 1:
      return nearest(axis.state.demand_position);
    default:
      return nearest(axis.servo.load_reading[axis.lane]);
  }
}

/// The internal target that `set_point` asks for.
double target_of(const DriveContext& axis, const SetPoint& set_point) {
  const auto value = static_cast<double>(set_point.position_user_target_value);
  return clamp_to_software_limits(axis, set_point.relative ? relative_base(axis) + value : value);
}

MoveTimes times_of(const SetPoint& set_point) {
  constexpr double kMicrosecond = 1.0e-6;
  return {.duration = set_point.synchronous_move_duration * kMicrosecond,
          .acceleration = set_point.synchronous_move_acceleration_time * kMicrosecond,
          .deceleration = set_point.synchronous_move_deceleration_time * kMicrosecond};
}

/// What the end of a profile means for the target.
void finish_motion(const DriveContext& axis) {
  DriveState& s = axis.state;
  const DriveRegisters& r = axis.registers;
  if (s.arrived || !s.powered) {
    return;
  }
  if (r.request.kind == Kind::move || r.request.kind == Kind::synchronous_move) {
    s.arrived = r.profile.reaches_target();
  } else if (!s.has_target && !s.limit_stop) {
    s.target = nearest(s.demand_position);
    s.arrived = true;
  }
}

/// The profile at the end of the tick.
void move_demand(const DriveContext& axis) {
  DriveState& s = axis.state;
  if (!s.powered) {
    rest_at(axis, axis.servo.load_reading[axis.lane]);
    return;
  }
  if (!s.moving) {
    return;
  }
  if (s.following) {
    s.demand_position = s.target;
    return;
  }
  s.plan_ticks += 1.0;
  const double time = (s.plan_ticks * axis.timing.substeps) * axis.timing.substep;
  if (time < s.segment.end_time) {
    const MotionSample now = sample(s.segment, time);
    s.demand_position = now.position;
    s.demand_velocity = now.velocity;
    return;
  }
  const Profile& profile = axis.registers.profile;
  if (time >= profile.duration()) {
    rest_at(axis, profile.end_position());
    return;
  }
  std::size_t i = 0;
  while (time >= profile.segment(i).end_time) {
    ++i;
  }
  s.segment = profile.segment(i);
  const MotionSample now = sample(s.segment, time);
  s.demand_position = now.position;
  s.demand_velocity = now.velocity;
}

/// Another loop becomes the outermost one: it starts from what the axis does.
void take_control(const DriveContext& axis, Control control) {
  DriveState& s = axis.state;
  if (control == s.control) {
    return;
  }
  ServoState& servo = axis.servo;
  const std::size_t l = axis.lane;
  if (s.control == Control::torque) {
    s.demand_velocity = servo.load_speed[l];
    s.moving = false;
  }
  if (control == Control::torque) {
    s.demand_torque = servo.command[l] * s.torque_per_mille;
    rest_at(axis, servo.load_reading[l]);
  }
  s.control = control;
  servo.closes_position[l] = control == Control::position ? 1.0 : 0.0;
  servo.torque_control[l] = control == Control::torque ? 1.0 : 0.0;
  axis.registers.request = {};
}

/// A new torque ramps from what is commanded: where a limit cuts the ramp off, not from its end.
void start_ramp(const DriveContext& axis, const MotionRequest& request) {
  DriveState& s = axis.state;
  const double commanded = axis.servo.command[axis.lane] * s.torque_per_mille;
  const double step = request.limits.acceleration * axis.timing.period_us * 1.0e-6;
  if (std::abs(s.demand_torque) > std::abs(commanded) + step) {
    s.demand_torque = commanded;
  }
}

/// One tick of the torque's ramp.
void ramp_torque(const DriveContext& axis, const MotionRequest& request) {
  DriveState& s = axis.state;
  const double most = request.limits.acceleration * axis.timing.period_us * 1.0e-6;
  const double left = request.target - s.demand_torque;
  const double change = std::min(std::max(left, -most), most);
  const std::size_t l = axis.lane;
  axis.servo.torque_wanted[l] = s.demand_torque / s.torque_per_mille;
  axis.servo.torque_step[l] = change / s.torque_per_mille / axis.timing.substeps;
  s.demand_torque = change == left ? request.target : s.demand_torque + change;
  s.moving = change != 0.0;
}

/// One tick straight to the streamed target, as far as the speed limit allows.
void follow_target(const DriveContext& axis, const MotionRequest& request) {
  DriveState& s = axis.state;
  const double period = axis.timing.period_us * 1.0e-6;
  const double most = request.limits.velocity * period;
  const double distance = request.target - s.demand_position;
  const double step = std::min(std::max(distance, -most), most);
  const double start = s.demand_position;
  rest_at(axis, start);
  s.demand_velocity = step / period;
  s.segment.velocity = s.demand_velocity;
  s.moving = step != 0.0;
  s.target = step == distance ? request.target : start + step;
}

Profile planned(const DriveContext& axis, const MotionRequest& request) {
  const MotionState start{axis.state.demand_position, axis.state.demand_velocity};
  switch (request.kind) {
    case Kind::move:
      return plan_move(start, request.target, request.limits);
    case Kind::synchronous_move:
      return plan_timed_move(start.position, request.target, axis.registers.synchronous_times);
    case Kind::velocity:
      return plan_velocity(start, request.target, request.limits);
    default:
      return plan_stop(start, request.limits.deceleration);
  }
}

void start_profile(const DriveContext& axis, const Profile& profile) {
  DriveState& s = axis.state;
  axis.registers.profile = profile;
  s.arrived = false;
  if (profile.segment_count() == 0) {
    rest_at(axis, profile.end_position());
    return;
  }
  s.segment = profile.segment(0);
  s.plan_ticks = 0.0;
  s.moving = true;
}

}  // namespace

void rest_at(const DriveContext& axis, double position) {
  DriveState& s = axis.state;
  s.demand_position = position;
  s.demand_velocity = 0.0;
  s.segment = {.end_time = kInfinity, .position = position};
  s.plan_ticks = 0.0;
  s.moving = false;
}

void shift_frame(const DriveContext& axis, const FrameShift& shift) {
  DriveState& s = axis.state;
  DriveRegisters& r = axis.registers;
  ServoState& servo = axis.servo;
  const std::size_t l = axis.lane;
  servo.position[l] -= shift.motor;
  servo.measured[l] -= shift.motor;
  servo.motor_reading[l] -= shift.motor;
  const double offset = r.index_offset - shift.motor;
  r.index_offset = offset - kUserUnitsPerRevolution * nearest(offset / kUserUnitsPerRevolution);
  r.index_reading -= shift.motor;
  servo.load_offset[l] += r.gear_ratio * shift.motor - shift.load;
  servo.load_position[l] -= shift.load;
  servo.load_measured[l] -= shift.reading;
  servo.load_reading[l] -= shift.reading;
  s.demand_position -= shift.reading;
  s.target -= shift.reading;
}

void rebase(const DriveContext& axis) {
  const ServoState& servo = axis.servo;
  const std::size_t l = axis.lane;
  const bool single = axis.registers.single_encoder;
  const double turns = whole_turns(axis.state.demand_position);
  const double motor = whole_turns(servo.motor_reading[l]);
  const double load = whole_turns(servo.load_position[l]);
  shift_frame(axis,
              {.motor = single ? turns : motor, .load = single ? load : turns, .reading = turns});
}

void drop_set_points(const DriveContext& axis) {
  DriveState& s = axis.state;
  s.queue.clear();
  s.has_target = false;
  s.active = false;
  s.streams = false;
  s.homing = HomingStage::idle;
  s.plan_due = true;
}

void seed_target(const DriveContext& axis) {
  DriveState& s = axis.state;
  drop_set_points(axis);
  s.target = nearest(s.demand_position);
  s.arrived = true;
  s.limit_stop = false;
  s.dwell = kSaturatedCount;
}

void replan(const DriveContext& axis) {
  DriveState& s = axis.state;
  DriveRegisters& r = axis.registers;
  s.plan_due = false;
  const MotionRequest request = requested_motion(axis);
  take_control(axis, control_of(axis, request));
  s.following = request.kind == Kind::follow;
  const bool same = request == r.request;
  r.request = request;
  r.synchronous_start = false;
  if (request.kind == Kind::torque) {
    if (!same) {
      start_ramp(axis, request);
    }
    ramp_torque(axis, request);
  } else if (request.kind == Kind::follow) {
    follow_target(axis, request);
  } else if (request.kind != Kind::hold && !same) {
    // Without power (hold) the demand follows the actual position.
    start_profile(axis, planned(axis, request));
  }
}

void advance_demand(const DriveContext& axis) {
  DriveState& s = axis.state;
  move_demand(axis);
  if (s.control != Control::position) {
    s.demand_position = axis.servo.load_reading[axis.lane];
  }
  if (!s.moving) {
    finish_motion(axis);
  }
}

bool can_start(const DriveContext& axis, const SetPoint& set_point) {
  if (set_point.synchronous_move_duration == 0) {
    return true;
  }
  const DriveState& s = axis.state;
  const MoveTimes times = times_of(set_point);
  const bool possible = times.acceleration > 0.0 && times.deceleration > 0.0 &&
                        times.acceleration + times.deceleration <= times.duration;
  if (s.moving || !possible) {
    return false;
  }
  rebase(axis);  // an absolute target counts from the frame that the set-point will start in
  rest_at(axis, s.demand_position);
  const MotionLimits limits = limits_of(target_of(axis, set_point) - s.demand_position, times);
  return limits.velocity <= axis.registers.velocity_cap &&
         limits.acceleration <= std::max(real(axis, "app_acc_limit"_object), 1.0) &&
         limits.deceleration <= std::max(real(axis, "app_dec_limit"_object), 1.0);
}

void start_set_point(const DriveContext& axis, const SetPoint& set_point) {
  DriveState& s = axis.state;
  DriveRegisters& r = axis.registers;
  rebase(axis);
  s.target = target_of(axis, set_point);
  r.set_point_velocity = static_cast<double>(set_point.profile_velocity);
  r.synchronous_times = times_of(set_point);
  if (r.synchronous_times.duration > 0.0) {
    r.synchronous_limits = limits_of(s.target - s.demand_position, r.synchronous_times);
    if (r.synchronous_limits.deceleration == 0.0) {
      r.synchronous_limits.deceleration = 1.0;  // no way: a halt plans its stop all the same
    }
  }
  r.synchronous_start = true;
  // The profile's start was rebased too: the request must not compare equal to one of before.
  r.request = {};
  s.has_target = true;
  s.active = true;
  s.arrived = false;
  s.limit_stop = false;
  s.dwell = 0;
  s.plan_due = true;
}

}  // namespace vdrive
