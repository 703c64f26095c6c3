// SPDX-License-Identifier: Apache-2.0
#include "drive/demand.hpp"

#include "drive/registers.hpp"
#include "drive/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdrive {
namespace {

using namespace vdrive::literals;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRange = 4294967296.0;  // of a 32-bit position register

double deceleration_of(const DriveContext& axis, ObjectRow row) {
  const double limit = std::max(real(axis, "app_dec_limit"_object), 1.0);
  return std::min(std::max(real(axis, row), 1.0), limit);
}

double acceleration_in_force(const DriveContext& axis) {
  const double limit = std::max(real(axis, "app_acc_limit"_object), 1.0);
  return std::min(std::max(real(axis, "profile_acc"_object), 1.0), limit);
}

MotionRequest stop_with(double deceleration) {
  return {.kind = MotionRequest::Kind::stop,
          .target = 0.0,
          .limits = {.velocity = 0.0, .acceleration = 1.0, .deceleration = deceleration}};
}

/// Option codes 605Ah, 605Dh, 605Eh: 1 normal ramp, 2 quick ramp, 3 and 4 the steepest there is.
MotionRequest stop_by_option(const DriveContext& axis, std::int64_t option) {
  switch (option) {
    case 1:
      return stop_with(deceleration_of(axis, "profile_dec"_object));
    case 2:
      return stop_with(deceleration_of(axis, "quick_stop_deceleration"_object));
    default:
      return stop_with(deceleration_of(axis, "app_dec_limit"_object));
  }
}

/// A limit switch stops what runs into it. A target on its far side is given up for good: bit 10
/// stays 0 until a new set-point; one on the near side is approached after the stop.
bool stopped_by_limit_switch(const DriveContext& axis) {
  DriveState& s = axis.state;
  const bool positive = (s.inputs & kPositiveLimitInput) != 0;
  const bool negative = (s.inputs & kNegativeLimitInput) != 0;
  if (!positive && !negative) {
    return false;
  }
  const double ahead = s.has_target ? s.target - s.demand_position : 0.0;
  if ((positive && ahead > 0.0) || (negative && ahead < 0.0)) {
    s.queue.drop_buffered(s.controlword);  // a master waits for bit 12 before it drops bit 4
    s.has_target = false;
    s.active = false;
    s.limit_stop = true;
  }
  return (positive && s.demand_velocity > 0.0) || (negative && s.demand_velocity < 0.0);
}

MotionRequest request_in_operation(const DriveContext& axis) {
  DriveState& s = axis.state;
  const bool mode_change = s.wanted_mode != s.mode;
  if (s.power.pending() != PowerCommand::none || mode_change) {
    return stop_with(deceleration_of(axis, "profile_dec"_object));
  }
  if (stopped_by_limit_switch(axis)) {
    return stop_with(deceleration_of(axis, "quick_stop_deceleration"_object));
  }
  if (s.mode == kProfilePosition && halted(axis)) {
    return stop_by_option(axis, reg(axis, "halt_option_code"_object));
  }
  if (s.mode == kProfilePosition && s.has_target) {
    return {.kind = MotionRequest::Kind::move,
            .target = s.target,
            .limits = {.velocity =
                           std::min(axis.registers.set_point_velocity, axis.registers.velocity_cap),
                       .acceleration = acceleration_in_force(axis),
                       .deceleration = deceleration_of(axis, "profile_dec"_object)}};
  }
  return stop_with(deceleration_of(
      axis, s.limit_stop ? "quick_stop_deceleration"_object : "profile_dec"_object));
}

MotionRequest requested_motion(const DriveContext& axis) {
  if (!axis.state.powered) {
    return {};
  }
  switch (axis.state.power.state()) {
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

double clamp_to_software_limits(const DriveContext& axis, double target) {
  const DriveState& s = axis.state;
  return s.limits_enabled ? std::min(std::max(target, s.lower_limit), s.upper_limit) : target;
}

/// What the end of a profile means for the target.
void finish_motion(const DriveContext& axis) {
  DriveState& s = axis.state;
  const DriveRegisters& r = axis.registers;
  if (s.arrived || !s.powered) {
    return;
  }
  if (r.request.kind == MotionRequest::Kind::move) {
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

}  // namespace

void rest_at(const DriveContext& axis, double position) {
  DriveState& s = axis.state;
  s.demand_position = position;
  s.demand_velocity = 0.0;
  s.segment = {.end_time = kInfinity, .position = position};
  s.plan_ticks = 0.0;
  s.moving = false;
}

void rebase(const DriveContext& axis) {
  DriveState& s = axis.state;
  ServoState& servo = axis.servo;
  const std::size_t l = axis.lane;
  const double shift = kRange * nearest(s.demand_position / kRange);
  const double motor_shift =
      axis.registers.single_encoder ? shift : kRange * nearest(servo.motor_reading[l] / kRange);
  servo.position[l] -= motor_shift;
  servo.measured[l] -= motor_shift;
  servo.motor_reading[l] -= motor_shift;
  const double load_shift =
      axis.registers.single_encoder ? kRange * nearest(servo.load_position[l] / kRange) : shift;
  servo.load_offset[l] += axis.registers.gear_ratio * motor_shift - load_shift;
  servo.load_position[l] -= load_shift;
  servo.load_measured[l] -= shift;
  servo.load_reading[l] -= shift;
  s.demand_position -= shift;
  s.target -= shift;
}

void drop_set_points(const DriveContext& axis) {
  DriveState& s = axis.state;
  s.queue.clear();
  s.has_target = false;
  s.active = false;
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
  if (request == r.request) {
    return;
  }
  r.request = request;
  if (request.kind == MotionRequest::Kind::hold) {
    return;  // without power the demand follows the actual position
  }
  const MotionState start{s.demand_position, s.demand_velocity};
  r.profile = request.kind == MotionRequest::Kind::move
                  ? plan_move(start, request.target, request.limits)
                  : plan_stop(start, request.limits.deceleration);
  s.arrived = false;
  if (r.profile.segment_count() == 0) {
    rest_at(axis, r.profile.end_position());
    return;
  }
  s.segment = r.profile.segment(0);
  s.plan_ticks = 0.0;
  s.moving = true;
}

void advance_demand(const DriveContext& axis) {
  move_demand(axis);
  if (!axis.state.moving) {
    finish_motion(axis);
  }
}

void start_set_point(const DriveContext& axis, const SetPoint& set_point) {
  DriveState& s = axis.state;
  rebase(axis);
  const auto value = static_cast<double>(set_point.position_user_target_value);
  const double target = set_point.relative ? relative_base(axis) + value : value;
  s.target = clamp_to_software_limits(axis, target);
  axis.registers.set_point_velocity = static_cast<double>(set_point.profile_velocity);
  // The profile's start was rebased too: the request must not compare equal to one of before.
  axis.registers.request = {};
  s.has_target = true;
  s.active = true;
  s.arrived = false;
  s.limit_stop = false;
  s.dwell = 0;
  s.plan_due = true;
}

}  // namespace vdrive
