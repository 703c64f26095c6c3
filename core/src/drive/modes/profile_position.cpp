// SPDX-License-Identifier: Apache-2.0
#include "drive/modes/profile_position.hpp"

#include "drive/frame.hpp"
#include "drive/limits.hpp"
#include "drive/modulo.hpp"
#include "drive/stops.hpp"
#include "drive/window.hpp"
#include "rounding.hpp"
#include "vdrive/cia402/positioning_option.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <cstdint>

namespace vdrive {
namespace {

using namespace vdrive::literals;
using Kind = MotionRequest::Kind;

/// The set-point that an edge of bit 4 would latch now.
SetPoint candidate(const Drive& drive) {
  return {.position_user_target_value =
              static_cast<std::int32_t>(reg(drive, "position_user_target_value"_object)),
          .profile_velocity = unsigned_reg(drive, "profile_velocity"_object),
          .synchronous_move_duration = unsigned_reg(drive, "synchronous_move_duration"_object),
          .synchronous_move_acceleration_time =
              unsigned_reg(drive, "synchronous_move_acceleration_time"_object),
          .synchronous_move_deceleration_time =
              unsigned_reg(drive, "synchronous_move_deceleration_time"_object),
          .synchronous_move_jerk_time = unsigned_reg(drive, "synchronous_move_jerk_time"_object),
          .synchronous_move_reference_way =
              unsigned_reg(drive, "synchronous_move_reference_way"_object),
          .positioning_option_code =
              static_cast<std::uint16_t>(reg(drive, "positioning_option_code"_object)),
          .relative = (drive.state().controlword & Controlword::kRelative) != 0};
}

/// The base of a relative set-point, by bits 0 and 1 of `option` (60F2h); the direction bits do not
/// matter.
double relative_base(const Drive& drive, std::int64_t option) {
  switch (option & PositioningOption::kRelativeBits) {
    case 0:
      return drive.state().target.position;
    case 1:
      return nearest(demand_position(drive));
    default:
      return nearest(actual_position(drive));
  }
}

/// The internal target of `set_point`. The sign of a relative set-point gives its direction, even
/// on a modulo axis.
double target_of(const Drive& drive, const SetPoint& set_point) {
  const auto value = static_cast<double>(set_point.position_user_target_value);
  const std::int64_t option = set_point.positioning_option_code;
  const double target =
      set_point.relative
          ? relative_base(drive, option) + value
          : target_on_range(drive, value, option, deceleration_of(drive, "profile_dec"_object));
  return within_software_limits(drive, target);
}

MoveTimes times_of(const SetPoint& set_point) {
  constexpr double kMicrosecond = 1.0e-6;
  return {.duration = set_point.synchronous_move_duration * kMicrosecond,
          .acceleration = set_point.synchronous_move_acceleration_time * kMicrosecond,
          .deceleration = set_point.synchronous_move_deceleration_time * kMicrosecond,
          .jerk = set_point.synchronous_move_jerk_time * kMicrosecond};
}

bool is_synchronous(const SetPoint& set_point) {
  return set_point.synchronous_move_duration != 0;
}

/// @return whether the times of `set_point` apply to its own distance, not to a reference distance.
bool is_timed(const SetPoint& set_point) {
  return is_synchronous(set_point) && set_point.synchronous_move_reference_way == 0;
}

/// A master sees the end of a motion only in 6062h and 606Bh. These are rounded, so they show the
/// end up to half a unit early, while the motion has not quite ended.
/// @return whether the demand is at rest or already shown as arrived.
bool shows_rest(const Drive& drive) {
  const DriveState& s = drive.state();
  return !s.demand.moving || (s.target.given && nearest(demand_velocity(drive)) == 0.0 &&
                              nearest(demand_position(drive)) == nearest(s.target.position));
}

/// @return whether a synchronous move (5E10h) can keep its times. With times for its own distance,
///         it must start from rest. There must be time to accelerate and to decelerate and, within
///         each of these, time for the jerk at both ends.
bool times_fit(const Drive& drive, const SetPoint& set_point) {
  const MoveTimes times = times_of(set_point);
  const bool from_here = !is_timed(set_point) || shows_rest(drive);
  return from_here && times.acceleration > 0.0 && times.deceleration > 0.0 &&
         times.acceleration + times.deceleration <= times.duration &&
         2.0 * times.jerk <= std::min(times.acceleration, times.deceleration);
}

/// Prepares a synchronous move with times for its own distance: rebases the positions and puts the
/// demand at rest, as at the start of the move. Only then is the distance to an absolute target
/// known, so that can_start() can check the move.
void enter_frame(Drive& drive, const SetPoint& set_point) {
  if (is_timed(set_point) && times_fit(drive, set_point)) {
    rebase(drive);
    rest_at(drive, demand_position(drive));
  }
}

/// @return the distance [UU] to which the times of a synchronous move to `target` apply; signed,
///         except for a reference distance.
double way_of_times(const Drive& drive, const SetPoint& set_point, double target) {
  return is_timed(set_point) ? target - demand_position(drive)
                             : set_point.synchronous_move_reference_way;
}

/// @return whether `set_point` may start now; call after enter_frame(). A synchronous move must be
///         within 607Fh, 6080h, 60C5h and 60C6h.
bool can_start(const Drive& drive, const SetPoint& set_point) {
  if (!is_synchronous(set_point)) return true;
  if (!times_fit(drive, set_point)) return false;
  const double way = way_of_times(drive, set_point, target_of(drive, set_point));
  const MotionLimits limits = limits_of(way, times_of(set_point));
  return limits.velocity <= drive.registers().velocity_cap &&
         limits.acceleration <= std::max(real(drive, "app_acc_limit"_object), 1.0) &&
         limits.deceleration <= std::max(real(drive, "app_dec_limit"_object), 1.0);
}

/// Makes `set_point` the active one; it is planned in the next tick.
void start(Drive& drive, const SetPoint& set_point) {
  DriveState& s = drive.state();
  DriveRegisters& r = drive.registers();
  rebase(drive);
  s.target = {.position = target_of(drive, set_point),
              .given = true,
              .fresh = s.target.fresh,
              .unplanned = true};
  r.set_point.velocity = static_cast<double>(set_point.profile_velocity);
  r.set_point.times = times_of(set_point);
  r.set_point.reference_way = set_point.synchronous_move_reference_way;
  if (r.set_point.times.duration > 0.0) {
    r.set_point.limits =
        limits_of(way_of_times(drive, set_point, s.target.position), r.set_point.times);
    // A move over no distance has deceleration 0, but the stop of a halt needs one above 0.
    if (r.set_point.limits.deceleration == 0.0) {
      r.set_point.limits.deceleration = 1.0;
    }
  }
  // Rebasing makes the present plan invalid. A request equal to the previous one would not be
  // planned again, so forget the previous one.
  r.request = {};
  s.modes.position.active = true;
  s.window.dwell = 0;
  s.plan_due = true;
}

/// The handshake of bits 4, 5 and 12.
void command(Drive& drive, const WrittenControlword& word) {
  DriveState& s = drive.state();
  SetPointState& set_points = s.modes.position;
  const SetPoint latched = candidate(drive);
  const bool accepting =
      word.accepting && (!halted(drive) || drive.registers().settings.acknowledge_while_halted);
  // A buffered set-point is checked when its turn comes, because its start is not known before.
  const bool waits = set_points.active && (s.controlword & Controlword::kChangeSetImmediately) == 0;
  if (accepting && !waits) enter_frame(drive, latched);
  const bool startable = accepting && (waits || can_start(drive, latched));
  switch (set_points.queue.controlword(s.controlword, word.previous, startable, set_points.active,
                                       latched)) {
    case SetPointOutcome::started:
      start(drive, latched);
      s.target.fresh = true;
      set_points.acknowledges_enabling = false;
      break;
    case SetPointOutcome::buffered:
      s.target.fresh = true;
      set_points.acknowledges_enabling = false;
      break;
    case SetPointOutcome::ignored:
      ++s.ignored_set_points;
      break;
    case SetPointOutcome::none:
      break;
  }
}

/// A target beyond a limit switch is given up: bit 10 stays 0 until a new set-point. A target short
/// of the switch is still approached after the stop.
void advance(Drive& drive) {
  DriveState& s = drive.state();
  const double ahead = s.target.given ? s.target.position - demand_position(drive) : 0.0;
  if (!give_up_target_at_limit_switch(drive, ahead)) return;
  // Keep bit 12: a master waits for it before it clears bit 4.
  s.modes.position.queue.drop_buffered(s.controlword);
  s.modes.position.active = false;
  s.target.given = false;
}

MotionRequest normal_stop(const Drive& drive) {
  return profile_stop(drive, "profile_dec"_object);
}

/// Jerk of the ramps given by the times of a synchronous move.
MotionJerk synchronous_jerk(const Drive& drive) {
  const ActiveSetPoint& set_point = drive.registers().set_point;
  return jerk_of(set_point.limits, set_point.times);
}

/// From rest, the plan takes the common times. After a halt the remaining distance is planned with
/// the same ramps and the same peak velocity, so that axes which halt and continue together stay on
/// their line. With a reference distance they do so from any state: if the states, distances and
/// limits of several axes are proportional to each other, so are their plans.
MotionRequest synchronous_move(const Drive& drive) {
  const DriveRegisters& r = drive.registers();
  const TargetState& target = drive.state().target;
  const bool timed = r.set_point.reference_way == 0.0 &&
                     (target.unplanned || r.request.kind == Kind::synchronous_move);
  return {.kind = timed ? Kind::synchronous_move : Kind::move,
          .target = target.position,
          .limits = r.set_point.limits,
          .times = r.set_point.times,
          .jerk = synchronous_jerk(drive)};
}

MotionRequest halt(const Drive& drive, bool synchronous) {
  const std::int64_t option = reg(drive, "halt_option_code"_object);
  if (!synchronous || option != 1) return stop_by_option(drive, option, normal_stop(drive));
  MotionRequest request = stop_with(drive.registers().set_point.limits.deceleration);
  request.jerk = synchronous_jerk(drive);
  return request;
}

/// A limit switch stops motion into it.
MotionRequest ask(const Drive& drive) {
  const DriveState& s = drive.state();
  const DriveRegisters& r = drive.registers();
  if (runs_into_limit_switch(drive, demand_velocity(drive))) return limit_switch_stop(drive);
  const bool synchronous = s.target.given && r.set_point.times.duration > 0.0;
  if (halted(drive)) return halt(drive, synchronous);
  if (synchronous) return synchronous_move(drive);
  if (!s.target.given) return s.target.given_up ? limit_switch_stop(drive) : normal_stop(drive);
  return {.kind = Kind::move,
          .target = s.target.position,
          .limits = {.velocity = std::min(r.set_point.velocity, r.velocity_cap),
                     .acceleration = acceleration_of(drive, "profile_acc"_object),
                     .deceleration = deceleration_of(drive, "profile_dec"_object)},
          .jerk = profile_jerk(drive)};
}

/// 6067h and 6068h apply to the target.
void watch(Drive& drive) {
  watch_target_window(drive);
}

/// Starts the buffered set-point when the active one is reached. The status of the same tick shows
/// it, so a master sees no gap between them.
void take_next(Drive& drive) {
  DriveState& s = drive.state();
  if (halted(drive) || !on_target(drive)) return;
  s.modes.position.active = false;
  SetPoint next;
  if (!s.modes.position.queue.take_buffered(s.controlword, next)) return;
  enter_frame(drive, next);
  if (can_start(drive, next)) {
    start(drive, next);
  } else {
    ++s.ignored_set_points;
  }
}

/// Bit 10: the target is reached, or under halt, standstill; bit 12: set-point acknowledge.
std::uint16_t status_bits(const Drive& drive) {
  const SetPointState& set_points = drive.state().modes.position;
  const bool acknowledged = set_points.queue.acknowledge() || set_points.acknowledges_enabling;
  return static_cast<std::uint16_t>(
      reached_when(halted(drive) ? at_rest(drive) : on_target(drive)) |
      (acknowledged ? Statusword::kSetPointAcknowledge : 0U));
}

}  // namespace

constinit const Mode kProfilePosition{.normal_ramp = "profile_dec"_object,
                                      .has_profile_type = true,
                                      .command = command,
                                      .advance = advance,
                                      .ask = ask,
                                      .watch = watch,
                                      .take_next = take_next,
                                      .status_bits = status_bits,
                                      .moves_steadily = true};

}  // namespace vdrive
