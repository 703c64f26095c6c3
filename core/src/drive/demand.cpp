// SPDX-License-Identifier: Apache-2.0
#include "drive/demand.hpp"

#include "drive/frame.hpp"
#include "drive/habits.hpp"
#include "drive/registers.hpp"
#include "rounding.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdrive {
namespace {

using Kind = MotionRequest::Kind;

/// @return the result of `ask` for the plan in force.
template <typename Ask>
auto of_plan(const Drive& drive, Ask ask) {
  const DriveRegisters& r = drive.registers();
  return drive.state().demand.by_jerk ? ask(r.jerk_profile) : ask(r.profile);
}

double plan_duration(const Drive& drive) {
  return of_plan(drive, [](const auto& plan) {
    return plan.duration();
  });
}

double plan_end(const Drive& drive) {
  return of_plan(drive, [](const auto& plan) {
    return plan.end_position();
  });
}

JerkSegment plan_segment_at(const Drive& drive, double time) {
  return of_plan(drive, [time](const auto& plan) {
    return with_jerk(plan.segment_at(time));
  });
}

/// Updates the target state at the end of a profile.
void finish_motion(Drive& drive) {
  DriveState& s = drive.state();
  const DriveRegisters& r = drive.registers();
  if (s.target.arrived || !s.power.on) return;
  if (r.request.kind == Kind::move || r.request.kind == Kind::synchronous_move) {
    s.target.arrived = of_plan(drive, [](const auto& plan) {
      return plan.reaches_target();
    });
  } else if (!s.target.given && !s.target.given_up) {
    s.target.position = nearest(demand_position(drive));
    s.target.arrived = true;
  }
}

/// Sets the demand to the segment in force at `time` [s] since the plan.
void sample_segment(Drive& drive, double time) {
  DemandBlock& demand = drive.demand();
  const std::size_t l = drive.lane();
  const MotionSample now = drive.state().demand.by_jerk ? sample(jerk_segment_of(demand, l), time)
                                                        : sample(segment_of(demand, l), time);
  demand.position[l] = now.position;
  demand.velocity[l] = now.velocity;
}

/// The tick ends in another segment or after the end of the profile.
void enter_segment(Drive& drive, double time) {
  if (time >= plan_duration(drive)) {
    rest_at(drive, plan_end(drive));
    return;
  }
  put_segment(drive, plan_segment_at(drive, time));
  sample_segment(drive, time);
}

/// Advances the profile to the end of the tick.
void advance_profile(Drive& drive) {
  DemandBlock& demand = drive.demand();
  const std::size_t l = drive.lane();
  demand.plan_ticks[l] += 1.0;
  const double time = plan_time(drive);
  if (time < demand.end_time[l]) {
    sample_segment(drive, time);
  } else {
    enter_segment(drive, time);
  }
}

/// Switches to another outermost loop, starting from the present motion of the axis.
void switch_control(Drive& drive, ControlLoop control) {
  DriveState& s = drive.state();
  if (control == s.demand.control) return;
  ServoState& servo = drive.servo();
  const std::size_t l = drive.lane();
  if (s.demand.control == ControlLoop::torque) {
    drive.demand().velocity[l] = servo.load_speed[l];
    s.demand.moving = false;
  }
  if (control == ControlLoop::torque) {
    s.demand.torque = commanded_torque(drive);
    drive.registers().torque_offset = 0.0;  // from now on the integrator follows the command
    rest_at(drive, servo.load_reading[l]);
  }
  s.demand.control = control;
  servo.closes_position[l] = control == ControlLoop::position ? 1.0 : 0.0;
  servo.torque_control[l] = control == ControlLoop::torque ? 1.0 : 0.0;
  drive.registers().request = {};
}

/// Shifts the integrator of the velocity loop by an additional torque. This has the effect of
/// adding the torque after the loop, without an addition in every servo step.
void feed_torque(Drive& drive, double torque) {
  DriveRegisters& r = drive.registers();
  if (torque == 0.0 && r.torque_offset == 0.0) return;
  const std::size_t l = drive.lane();
  const double wanted = torque / drive.block().units.torque_per_mille[l];
  drive.servo().integrator[l] += wanted - r.torque_offset;
  r.torque_offset = wanted;
}

/// Starts a torque ramp. If a limit has kept the commanded torque below the demand of the previous
/// ramp, the new ramp starts from the commanded torque.
void start_ramp(Drive& drive, const MotionRequest& request) {
  DriveState& s = drive.state();
  const double commanded = commanded_torque(drive);
  const double step = request.limits.acceleration * drive.timing().period_us * 1.0e-6;
  if (std::abs(s.demand.torque) > std::abs(commanded) + step) s.demand.torque = commanded;
}

/// Changes the commanded torque by `change` over a tick, starting from the torque demand, in equal
/// steps per sub-step.
void step_torque(Drive& drive, double change) {
  const std::size_t l = drive.lane();
  const double unit = drive.block().units.torque_per_mille[l];
  drive.servo().torque_wanted[l] = drive.state().demand.torque / unit;
  drive.servo().torque_step[l] = change / unit / drive.timing().substeps;
}

void ramp_torque(Drive& drive, const MotionRequest& request) {
  DriveState& s = drive.state();
  const double most = request.limits.acceleration * drive.timing().period_us * 1.0e-6;
  const double left = request.target - s.demand.torque;
  const double change = std::min(std::max(left, -most), most);
  step_torque(drive, change);
  s.demand.torque = change == left ? request.target : s.demand.torque + change;
  s.demand.moving = change != 0.0;
}

/// Moves the demand straight to the streamed position in one tick, within the speed limit. A
/// velocity offset is passed to the position loop as a shifted position, which has the same effect;
/// 6062h does not show the shift.
void follow_target(Drive& drive, const MotionRequest& request) {
  DriveState& s = drive.state();
  const double period = drive.timing().period_us * 1.0e-6;
  const double most = request.limits.velocity * period;
  const double distance = request.target - demand_position(drive);
  const double step = std::min(std::max(distance, -most), most);
  const double start = demand_position(drive);
  const std::size_t l = drive.lane();
  rest_at(drive, start);
  drive.demand().velocity[l] = step / period;
  drive.demand().segment_velocity[l] = step / period;
  if (request.velocity_offset != 0.0) {
    drive.demand().segment_position[l] =
        start + request.velocity_offset / drive.registers().position_gain;
  }
  s.demand.moving = step != 0.0;
  s.target.position = step == distance ? request.target : start + step;
}

/// Moves the demand to the streamed velocity in one tick, at constant acceleration and within the
/// speed limit.
void follow_velocity(Drive& drive, const MotionRequest& request) {
  const double most = request.limits.velocity;
  const double start = demand_velocity(drive);
  const double end = std::min(std::max(request.target, -most), most);
  const std::size_t l = drive.lane();
  rest_at(drive, demand_position(drive));
  drive.demand().velocity[l] = end;
  drive.demand().segment_velocity[l] = start;
  drive.demand().segment_acceleration[l] = (end - start) / (drive.timing().period_us * 1.0e-6);
  drive.state().demand.moving = start != 0.0 || end != 0.0;
}

/// Moves the demand to the streamed torque in one tick.
void follow_torque(Drive& drive, const MotionRequest& request) {
  DriveState& s = drive.state();
  const double change = request.target - s.demand.torque;
  step_torque(drive, change);
  s.demand.torque = request.target;
  s.demand.moving = change != 0.0;
}

void follow_stream(Drive& drive, const MotionRequest& request) {
  switch (request.control) {
    case ControlLoop::position:
      follow_target(drive, request);
      break;
    case ControlLoop::velocity:
      follow_velocity(drive, request);
      break;
    case ControlLoop::torque:
      follow_torque(drive, request);
      break;
  }
}

Profile planned(const Drive& drive, const MotionRequest& request) {
  const double velocity = plans_from_rest(drive, request.kind) ? 0.0 : demand_velocity(drive);
  const MotionState start{demand_position(drive), velocity};
  switch (request.kind) {
    case Kind::move:
      return plan_move(start, request.target, request.limits);
    case Kind::synchronous_move:
      return plan_timed_move(start.position, request.target, request.times);
    case Kind::velocity:
      return plan_velocity(start, request.target, request.limits);
    default:
      return plan_stop(start, request.limits.deceleration);
  }
}

/// @return whether the motion needs a plan with jerk. For a synchronous move its times decide.
bool needs_jerk(const MotionRequest& request) {
  return request.kind == Kind::synchronous_move ? request.times.jerk > 0.0
                                                : is_limited(request.jerk);
}

JerkProfile planned_by_jerk(const Drive& drive, const MotionRequest& request) {
  const bool from_rest = plans_from_rest(drive, request.kind);
  const MotionSample start{
      demand_position(drive), from_rest ? 0.0 : demand_velocity(drive),
      from_rest ? 0.0 : starting_acceleration(drive, request.limits, request.jerk)};
  switch (request.kind) {
    case Kind::move:
      return plan_jerk_move(start, request.target, request.limits, request.jerk);
    case Kind::synchronous_move:
      return plan_timed_jerk_move(start.position, request.target, request.times);
    case Kind::velocity:
      return plan_jerk_velocity(start, request.target, request.limits, request.jerk);
    default:
      return plan_jerk_stop(start, request.limits.deceleration, request.jerk);
  }
}

void start_motion(Drive& drive, const MotionRequest& request) {
  DriveState& s = drive.state();
  DriveRegisters& r = drive.registers();
  std::uint64_t& jerk_limited = drive.block().jerk_limited;
  const std::uint64_t bit = std::uint64_t{1} << drive.lane();
  s.demand.by_jerk = needs_jerk(request);
  if (s.demand.by_jerk) {
    r.jerk_profile = planned_by_jerk(drive, request);
    jerk_limited |= bit;
  } else {
    r.profile = planned(drive, request);
    jerk_limited &= ~bit;
  }
  s.target.arrived = false;
  if (!(plan_duration(drive) > 0.0)) {
    rest_at(drive, plan_end(drive));
    return;
  }
  put_segment(drive, plan_segment_at(drive, 0.0));
  drive.demand().plan_ticks[drive.lane()] = 0.0;
  s.demand.moving = true;
}

}  // namespace

void plan(Drive& drive, const MotionRequest& request) {
  DriveState& s = drive.state();
  DriveRegisters& r = drive.registers();
  switch_control(drive, request.control);
  feed_torque(drive, request.torque_offset);
  s.demand.following = request.kind == Kind::follow;
  const bool same = request == r.request;
  r.request = request;
  s.target.unplanned = false;
  if (request.kind == Kind::torque) {
    if (!same) start_ramp(drive, request);
    ramp_torque(drive, request);
  } else if (request.kind == Kind::follow) {
    follow_stream(drive, request);
  } else if (request.kind != Kind::hold && !same) {
    // hold = no power: the demand follows the actual position without a plan.
    start_motion(drive, request);
  }
}

std::size_t cross_segments(Drive& drive, std::size_t substep) {
  const TickTiming& timing = drive.timing();
  DemandBlock& demand = drive.demand();
  const std::size_t l = drive.lane();
  const double first = demand.plan_ticks[l] * timing.substeps;
  const auto time_at = [&timing, first](std::size_t k) {
    return (first + static_cast<double>(k)) * timing.substep;
  };
  const double end_time = demand.end_time[l];
  const JerkSegment segment = plan_segment_at(drive, time_at(substep));
  put_segment(drive, segment);
  demand.end_time[l] = end_time;
  while (substep < timing.substeps && time_at(substep) < segment.end_time) ++substep;
  return substep;
}

void advance_demand(Drive& drive) {
  DriveState& s = drive.state();
  if (!s.power.on) {
    rest_at(drive, actual_position(drive));
  } else if (s.demand.moving && s.demand.following) {
    drive.demand().position[drive.lane()] = s.target.position;
  } else if (s.demand.moving) {
    advance_profile(drive);
  }
  if (s.demand.control != ControlLoop::position) {
    drive.demand().position[drive.lane()] = actual_position(drive);
  }
  if (!s.demand.moving) finish_motion(drive);
}

}  // namespace vdrive
