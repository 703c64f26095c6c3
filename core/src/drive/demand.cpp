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
      return axis.state.target.position;
    case 1:
      return nearest(axis.state.demand.position);
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
  if (s.target.arrived || !s.power.on) {
    return;
  }
  if (r.request.kind == Kind::move || r.request.kind == Kind::synchronous_move) {
    s.target.arrived = r.profile.reaches_target();
  } else if (!s.target.given && !s.target.given_up) {
    s.target.position = nearest(s.demand.position);
    s.target.arrived = true;
  }
}

/// The profile at the end of the tick.
void move_demand(const DriveContext& axis) {
  DriveState& s = axis.state;
  if (!s.power.on) {
    rest_at(axis, axis.servo.load_reading[axis.lane]);
    return;
  }
  if (!s.demand.moving) {
    return;
  }
  if (s.demand.following) {
    s.demand.position = s.target.position;
    return;
  }
  s.demand.plan_ticks += 1.0;
  const double time = (s.demand.plan_ticks * axis.timing.substeps) * axis.timing.substep;
  if (time < s.demand.segment.end_time) {
    const MotionSample now = sample(s.demand.segment, time);
    s.demand.position = now.position;
    s.demand.velocity = now.velocity;
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
  s.demand.segment = profile.segment(i);
  const MotionSample now = sample(s.demand.segment, time);
  s.demand.position = now.position;
  s.demand.velocity = now.velocity;
}

/// Another loop becomes the outermost one: it starts from what the axis does.
void take_control(const DriveContext& axis, Control control) {
  DriveState& s = axis.state;
  if (control == s.demand.control) {
    return;
  }
  ServoState& servo = axis.servo;
  const std::size_t l = axis.lane;
  if (s.demand.control == Control::torque) {
    s.demand.velocity = servo.load_speed[l];
    s.demand.moving = false;
  }
  if (control == Control::torque) {
    s.demand.torque = servo.command[l] * s.units.torque_per_mille;
    rest_at(axis, servo.load_reading[l]);
  }
  s.demand.control = control;
  servo.closes_position[l] = control == Control::position ? 1.0 : 0.0;
  servo.torque_control[l] = control == Control::torque ? 1.0 : 0.0;
  axis.registers.request = {};
}

/// A new torque ramps from what is commanded: where a limit cuts the ramp off, not from its end.
void start_ramp(const DriveContext& axis, const MotionRequest& request) {
  DriveState& s = axis.state;
  const double commanded = axis.servo.command[axis.lane] * s.units.torque_per_mille;
  const double step = request.limits.acceleration * axis.timing.period_us * 1.0e-6;
  if (std::abs(s.demand.torque) > std::abs(commanded) + step) {
    s.demand.torque = commanded;
  }
}

/// One tick of the torque's ramp.
void ramp_torque(const DriveContext& axis, const MotionRequest& request) {
  DriveState& s = axis.state;
  const double most = request.limits.acceleration * axis.timing.period_us * 1.0e-6;
  const double left = request.target - s.demand.torque;
  const double change = std::min(std::max(left, -most), most);
  const std::size_t l = axis.lane;
  axis.servo.torque_wanted[l] = s.demand.torque / s.units.torque_per_mille;
  axis.servo.torque_step[l] = change / s.units.torque_per_mille / axis.timing.substeps;
  s.demand.torque = change == left ? request.target : s.demand.torque + change;
  s.demand.moving = change != 0.0;
}

/// One tick straight to the streamed target, as far as the speed limit allows.
void follow_target(const DriveContext& axis, const MotionRequest& request) {
  DriveState& s = axis.state;
  const double period = axis.timing.period_us * 1.0e-6;
  const double most = request.limits.velocity * period;
  const double distance = request.target - s.demand.position;
  const double step = std::min(std::max(distance, -most), most);
  const double start = s.demand.position;
  rest_at(axis, start);
  s.demand.velocity = step / period;
  s.demand.segment.velocity = s.demand.velocity;
  s.demand.moving = step != 0.0;
  s.target.position = step == distance ? request.target : start + step;
}

Profile planned(const DriveContext& axis, const MotionRequest& request) {
  const MotionState start{axis.state.demand.position, axis.state.demand.velocity};
  switch (request.kind) {
    case Kind::move:
      return plan_move(start, request.target, request.limits);
    case Kind::synchronous_move:
      return plan_timed_move(start.position, request.target, axis.registers.set_point.times);
    case Kind::velocity:
      return plan_velocity(start, request.target, request.limits);
    default:
      return plan_stop(start, request.limits.deceleration);
  }
}

void start_profile(const DriveContext& axis, const Profile& profile) {
  DriveState& s = axis.state;
  axis.registers.profile = profile;
  s.target.arrived = false;
  if (profile.segment_count() == 0) {
    rest_at(axis, profile.end_position());
    return;
  }
  s.demand.segment = profile.segment(0);
  s.demand.plan_ticks = 0.0;
  s.demand.moving = true;
}

}  // namespace

void rest_at(const DriveContext& axis, double position) {
  DriveState& s = axis.state;
  s.demand.position = position;
  s.demand.velocity = 0.0;
  s.demand.segment = {.end_time = kInfinity, .position = position};
  s.demand.plan_ticks = 0.0;
  s.demand.moving = false;
}

void shift_frame(const DriveContext& axis, const FrameShift& shift) {
  DriveState& s = axis.state;
  DriveRegisters& r = axis.registers;
  ServoState& servo = axis.servo;
  const std::size_t l = axis.lane;
  servo.position[l] -= shift.motor;
  servo.measured[l] -= shift.motor;
  servo.motor_reading[l] -= shift.motor;
  const double offset = r.index.offset - shift.motor;
  r.index.offset = offset - kUserUnitsPerRevolution * nearest(offset / kUserUnitsPerRevolution);
  r.index.reading -= shift.motor;
  servo.load_offset[l] += r.gear_ratio * shift.motor - shift.load;
  servo.load_position[l] -= shift.load;
  servo.load_measured[l] -= shift.reading;
  servo.load_reading[l] -= shift.reading;
  s.demand.position -= shift.reading;
  s.target.position -= shift.reading;
}

void rebase(const DriveContext& axis) {
  const ServoState& servo = axis.servo;
  const std::size_t l = axis.lane;
  const bool single = axis.registers.single_encoder;
  const double turns = whole_turns(axis.state.demand.position);
  const double motor = whole_turns(servo.motor_reading[l]);
  const double load = whole_turns(servo.load_position[l]);
  shift_frame(axis,
              {.motor = single ? turns : motor, .load = single ? load : turns, .reading = turns});
}

void drop_set_points(const DriveContext& axis) {
  DriveState& s = axis.state;
  s.set_points.queue.clear();
  s.target.given = false;
  s.set_points.active = false;
  s.cyclic.streams = false;
  s.homing.stage = HomingStage::idle;
  s.plan_due = true;
}

void seed_target(const DriveContext& axis) {
  DriveState& s = axis.state;
  drop_set_points(axis);
  s.target.position = nearest(s.demand.position);
  s.target.arrived = true;
  s.target.given_up = false;
  s.window.dwell = kSaturatedCount;
}

void replan(const DriveContext& axis) {
  DriveState& s = axis.state;
  DriveRegisters& r = axis.registers;
  s.plan_due = false;
  const MotionRequest request = requested_motion(axis);
  take_control(axis, control_of(axis, request));
  s.demand.following = request.kind == Kind::follow;
  const bool same = request == r.request;
  r.request = request;
  r.set_point.starts = false;
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
  if (s.demand.control != Control::position) {
    s.demand.position = axis.servo.load_reading[axis.lane];
  }
  if (!s.demand.moving) {
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
  if (s.demand.moving || !possible) {
    return false;
  }
  rebase(axis);  // an absolute target counts from the frame that the set-point will start in
  rest_at(axis, s.demand.position);
  const MotionLimits limits = limits_of(target_of(axis, set_point) - s.demand.position, times);
  return limits.velocity <= axis.registers.velocity_cap &&
         limits.acceleration <= std::max(real(axis, "app_acc_limit"_object), 1.0) &&
         limits.deceleration <= std::max(real(axis, "app_dec_limit"_object), 1.0);
}

void start_set_point(const DriveContext& axis, const SetPoint& set_point) {
  DriveState& s = axis.state;
  DriveRegisters& r = axis.registers;
  rebase(axis);
  s.target.position = target_of(axis, set_point);
  r.set_point.velocity = static_cast<double>(set_point.profile_velocity);
  r.set_point.times = times_of(set_point);
  if (r.set_point.times.duration > 0.0) {
    r.set_point.limits = limits_of(s.target.position - s.demand.position, r.set_point.times);
    if (r.set_point.limits.deceleration == 0.0) {
      r.set_point.limits.deceleration = 1.0;  // no way: a halt plans its stop all the same
    }
  }
  r.set_point.starts = true;
  // The profile's start was rebased too: the request must not compare equal to one of before.
  r.request = {};
  s.target.given = true;
  s.set_points.active = true;
  s.target.arrived = false;
  s.target.given_up = false;
  s.window.dwell = 0;
  s.plan_due = true;
}

}  // namespace vdrive
