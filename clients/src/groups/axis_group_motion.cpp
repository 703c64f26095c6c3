// SPDX-License-Identifier: Apache-2.0
// Straight lines: times, common start tick, arrival, queue.
#include "base/drive_words.hpp"
#include "calls/arrival.hpp"
#include "calls/axes_command.hpp"
#include "calls/profile_move.hpp"
#include "groups/group_state.hpp"
#include "vdrive/cia402/positioning_option.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/plant/axis_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using namespace literals;

// Added to the duration of a line, for the position window time (6068h) and a servo that lags.
constexpr std::chrono::seconds kBeyondDuration{5};

// An axis at rest may be this far from the integer position in 6062h [UU].
constexpr double kRestTolerance = 0.5;

constexpr ObjectAddress kDuration = kObjectRows["synchronous_move_duration"_object].address;
constexpr ObjectAddress kAccelerationTime =
    kObjectRows["synchronous_move_acceleration_time"_object].address;
constexpr ObjectAddress kDecelerationTime =
    kObjectRows["synchronous_move_deceleration_time"_object].address;
constexpr ObjectAddress kJerkTime = kObjectRows["synchronous_move_jerk_time"_object].address;
constexpr ObjectAddress kReferenceWay =
    kObjectRows["synchronous_move_reference_way"_object].address;

/// The objects that determine the times of a line, in the order of LimitObject.
constexpr auto kLimitObjects =
    move_bounds_and<"motor_speed_limit"_object, "app_position_limit_switch"_object,
                    "user_position_lower_limit"_object, "user_position_upper_limit"_object,
                    "min_position_range_limit"_object, "max_position_range_limit"_object,
                    "positioning_option_code"_object, "motion_profile_type"_object,
                    "profile_jerk_use"_object, "profile_jerk_1"_object, "profile_jerk_2"_object,
                    "habit_plan_from_rest"_object, "habit_controlword_loop"_object>();

enum LimitObject : std::size_t {
  profile_velocity,
  profile_acceleration,
  profile_deceleration,
  speed_limit,
  acceleration_limit,
  deceleration_limit,
  motor_speed_limit,
  position_limit_switch,
  lower_limit,
  upper_limit,
  range_begin,
  range_end,
  positioning_option,
  motion_profile_type,
  profile_jerk_use,
  profile_jerk_1,
  profile_jerk_2,
  habit_plan_from_rest,
  habit_controlword_loop,
};

/// @param range the beginning of the reason, such as "is beyond its software limits (607Dh), from "
Outcome beyond_range(const AxesCall& call, const AxisId& axis, std::int64_t target,
                     std::string_view range, std::int64_t begin, std::string_view to,
                     std::int64_t end) {
  const Unit unit = call.unit_of(axis);
  const auto text = [&unit](std::int64_t position) {
    return quantity_text(position, Dimension::position, unit);
  };
  return Outcome::refused(wire_code(AbortCode::value_range_exceeded),
                          "axis " + to_string(axis) + ": the target " + text(target) + " " +
                              std::string(range) + text(begin) + std::string(to) + text(end));
}

/// A line is planned as for linear axes: on a modulo axis (607Bh), its target must be a position
/// that 6062h can show, and its distance is the difference of two such positions.
Outcome check_range(const AxesCall& call, const AxisId& axis,
                    const std::vector<std::int64_t>& values, std::int64_t target) {
  if (values[range_begin] >= values[range_end]) return {};
  if (target < values[range_begin] || target >= values[range_end]) {
    return beyond_range(call, axis, target, "is outside of its position range (607Bh), from ",
                        values[range_begin], " to below ", values[range_end]);
  }
  if ((values[positioning_option] & PositioningOption::kDirectionBits) == 0) return {};
  return not_in_this_state("axis " + to_string(axis) +
                           ": positioning_option_code (60F2h) selects a direction, which a line "
                           "cannot follow; write it without bits 6 and 7");
}

/// Two habits make a drive leave the line: forgetting the speed of a moving axis, and evaluating
/// the controlword only once per loop, so that its start is not predictable.
Outcome check_habits(const std::string& axis, const std::vector<std::int64_t>& values,
                     bool in_motion) {
  if (values[habit_controlword_loop] != 0) {
    return not_in_this_state(
        axis + ": habit_controlword_loop (5E20h:06) is " +
        std::to_string(values[habit_controlword_loop]) +
        ", but must be 0 for a line: the axis would start later than the others");
  }
  if (!in_motion || values[habit_plan_from_rest] == 0) return {};
  return not_in_this_state(
      axis +
      ": habit_plan_from_rest (5E20h:0B) is 1, but must be 0 for a line that starts in motion");
}

/// The limits of one axis as the drive applies them.
MotionLimits limits_from(const std::vector<std::int64_t>& values, const LineRequest& request) {
  const auto real = [&values](LimitObject object) {
    return static_cast<double>(values[object]);
  };
  const auto ramp = [&](LimitObject profile, LimitObject cap) {
    return std::min(real(profile), real(cap));
  };
  return {
      .velocity = request.velocity_factor *
                  std::min({real(profile_velocity), real(speed_limit), real(motor_speed_limit)}),
      .acceleration = request.acceleration_factor * ramp(profile_acceleration, acceleration_limit),
      .deceleration = request.deceleration_factor * ramp(profile_deceleration, deceleration_limit)};
}

/// The jerk of one axis as the drive applies it.
MotionJerk jerk_from(const std::vector<std::int64_t>& values) {
  constexpr std::int64_t kLimitedJerk = 3;  // a value of 6086h
  if (values[motion_profile_type] != kLimitedJerk) return {};
  const bool has_two = values[profile_jerk_use] == 2;
  return {.acceleration = static_cast<double>(values[profile_jerk_1]),
          .deceleration = static_cast<double>(values[has_two ? profile_jerk_2 : profile_jerk_1])};
}

void add_target(msg::AxisCommand& command, std::int32_t target) {
  command.members =
      static_cast<std::uint16_t>(command.members | msg::HAS_POSITION_USER_TARGET_VALUE);
  command.position_user_target_value = target;
}

/// The complete handshake: bit 4 low, the edge with the set-point and the common times, bit 4 low
/// again. The drive latches the times on the edge; clearing them keeps them from affecting later
/// moves.
std::array<Round, 3> start_rounds(const AxesCall& call, const LineRequest& request,
                                  const LinePlan& plan) {
  std::array<Round, 3> rounds{call.round_of(kEnableOperation, every_axis),
                              call.round_of(kEnableOperation, every_axis),
                              call.round_of(kEnableOperation, every_axis)};
  for (Round& round : rounds) round.flags = msg::FRAME_ALL_OR_NOTHING;
  for (std::size_t place = 0; place < request.targets.size(); ++place) {
    msg::AxisCommand& before = rounds[0].entries[place].command;
    before.members = static_cast<std::uint16_t>(before.members | msg::HAS_OP_MODE_CMD);
    before.op_mode_cmd = static_cast<std::int8_t>(OperatingMode::profile_position);
    msg::AxisCommand& edge = rounds[1].entries[place].command;
    add_object(edge, kDuration, plan.times.duration.count());
    add_object(edge, kAccelerationTime, plan.times.acceleration.count());
    add_object(edge, kDecelerationTime, plan.times.deceleration.count());
    add_object(edge, kJerkTime, plan.times.jerk.count());
    add_object(edge, kReferenceWay, plan.reference_ways[place]);
    add_target(edge, request.targets[place]);
    add_word(edge,
             kEnableOperation | Controlword::kNewSetPoint | Controlword::kChangeSetImmediately);
    add_object(rounds[2].entries[place].command, kDuration, 0);
    add_object(rounds[2].entries[place].command, kReferenceWay, 0);
  }
  return rounds;
}

std::vector<std::int32_t> demands_of(std::span<const AxisSnapshot> axes) {
  std::vector<std::int32_t> demands;
  demands.reserve(axes.size());
  for (const AxisSnapshot& axis : axes) demands.push_back(axis.status.position_demand_value);
  return demands;
}

/// A drive takes no set-point before it shows the mode. It shows the mode later than commanded if
/// it has the habit 5E20h:08, or if the axis must first come to rest. In a mode without a position
/// loop, 606Bh does not show whether an axis is at rest. Axes that may be late get the mode before
/// the line, not with it.
Outcome await_late_mode(AxesCall& call) {
  constexpr OperatingMode kMode = OperatingMode::profile_position;
  const auto has_mode = [](const AxisSnapshot& axis) {
    return axis.mode() == kMode;
  };
  if (std::ranges::all_of(call.snapshots(), has_mode)) return {};
  const auto delays = call.read(std::array{kObjectRows["habit_mode_display_delay"_object].address});
  if (!delays) return delays.outcome();
  const bool is_late = std::ranges::any_of(*delays, [](const std::vector<std::int64_t>& values) {
    return values.front() != 0;
  });
  const bool may_move = std::ranges::any_of(call.snapshots(), [](const AxisSnapshot& axis) {
    return axis.mode() != kMode && axis.mode() != OperatingMode::none;
  });
  if (!is_late && !may_move) return {};
  const Round mode = mode_round(call, kMode);
  const Answers answers = call.exchange({&mode, 1}, Timing::at_once);
  if (!answers.outcome) return answers.outcome;
  return call.await_enabled(std::string(to_string(kMode)) + " mode", answers.tick, has_mode);
}

bool demand_arrived(const AxisSnapshot& axis, std::int32_t target) {
  return axis.status.position_demand_value == target && axis.status.velocity_demand_value == 0;
}

}  // namespace

Result<std::vector<AxisDistance>> AxisGroup::State::ways_of(AxesCall& call,
                                                            const LineRequest& request,
                                                            bool in_motion) const {
  const auto limits = call.read(kLimitObjects);
  if (!limits) return limits.outcome();
  std::vector<AxisDistance> ways;
  for (std::size_t place = 0; place < request.targets.size(); ++place) {
    const std::vector<std::int64_t>& values = (*limits)[place];
    const std::string axis = "axis " + to_string(layout.axes[place]);
    const std::int64_t target = request.targets[place];
    if (values[position_limit_switch] != 0 &&
        (target < values[lower_limit] || target > values[upper_limit])) {
      return beyond_range(call, layout.axes[place], target,
                          "is beyond its software limits (607Dh), from ", values[lower_limit],
                          " to ", values[upper_limit]);
    }
    if (Outcome within = check_range(call, layout.axes[place], values, target); !within) {
      return within;
    }
    if (Outcome keeps = check_habits(axis, values, in_motion); !keeps) return keeps;
    const auto bounds = std::span(values).first(kMoveBounds.size());
    if (Outcome moves = check_bounds(layout.axes[place], bounds); !moves) return moves;
    const MotionLimits own = limits_from(values, request);
    const double way =
        static_cast<double>(target) - call.snapshots()[place].status.position_demand_value;
    ways.push_back(
        {.distance = std::abs(way) + kRestTolerance, .limits = own, .jerk = jerk_from(values)});
  }
  return ways;
}

Outcome AxisGroup::State::takes_too_long(std::span<const AxisDistance> ways) const {
  const auto slowest = std::ranges::max_element(ways, {}, [](const AxisDistance& way) {
    return way.distance / way.limits.velocity;
  });
  return not_in_this_state(
      "axis " + to_string(layout.axes[static_cast<std::size_t>(slowest - ways.begin())]) +
      " would take longer than a synchronous move can last, 4294 s");
}

Result<LinePlan> AxisGroup::State::plan_from_rest(AxesCall& call,
                                                  const LineRequest& request) const {
  const auto ways = ways_of(call, request, false);
  if (!ways) return ways.outcome();
  const auto times = plan_line(*ways, call.period());
  if (!times) return takes_too_long(*ways);
  return LinePlan{.times = *times,
                  .reference_ways = std::vector<std::int64_t>(request.targets.size(), 0),
                  .duration = times->duration,
                  .course = {.origin = demands_of(call.snapshots()), .farthest = request.targets}};
}

/// In real time the axes move on until the line starts, so only the course of the line is planned
/// here: each drive plans along it from its position at that time.
Result<LinePlan> AxisGroup::State::plan_in_motion(AxesCall& call, const LineRequest& request) {
  const std::vector<AxisSnapshot>& axes = call.snapshots();
  const auto moving = active_line();
  std::vector<Unit> units;
  for (const AxisId& axis : layout.axes) units.push_back(call.unit_of(axis));
  auto course = continued_course(moving ? std::optional(moving->course) : std::nullopt, axes,
                                 request.targets, units);
  if (!course) return course.outcome();
  auto ways = ways_of(call, request, true);
  if (!ways) return ways.outcome();
  const std::vector<double> along = ways_along(*course);
  for (std::size_t place = 0; place < along.size(); ++place) {
    (*ways)[place].distance = along[place];
  }
  const auto plan = plan_moving_line(*ways);
  if (!plan) return takes_too_long(*ways);
  LinePlan planned{
      .times = plan->times, .reference_ways = {}, .duration = {}, .course = std::move(*course)};
  double left = 0.0;
  double speed = 0.0;
  for (std::size_t place = 0; place < along.size(); ++place) {
    const double way = along[place] * plan->stretch;
    const AxisStatus& status = axes[place].status;
    const double ahead = static_cast<double>(request.targets[place]) - status.position_demand_value;
    left = std::max(left, std::abs(ahead) / way);
    speed = std::max(speed, std::abs(static_cast<double>(status.velocity_demand_value)) / way);
    planned.reference_ways.push_back(std::llround(way));
  }
  planned.duration = longest_duration(plan->times, left, speed);
  return planned;
}

Outcome AxisGroup::State::start(AxesCall& call, const LineRequest& request) {
  if (Outcome able = call.require(is_enabled, "a move", "Operation enabled"); !able) return able;
  const bool in_motion = is_on_the_move(call.snapshots());
  if (!in_motion) {
    if (Outcome moded = await_late_mode(call); !moded) return moded;
  }
  const auto plan = in_motion ? plan_in_motion(call, request) : plan_from_rest(call, request);
  if (!plan) return plan.outcome();
  const Answers answers = call.exchange(start_rounds(call, request, *plan), Timing::common_tick);
  if (answers.outcome && answers.ignored.empty()) {
    set_line(ActiveLine{.starts = demands_of(call.snapshots()),
                        .targets = request.targets,
                        .duration = plan->duration,
                        .start_tick = answers.tick,
                        .course = plan->course,
                        .given = call.given()});
    return {};
  }
  const bool is_lost = answers.outcome.kind() == OutcomeKind::lost;
  if (is_lost || answers.tick != 0) set_line(std::nullopt);
  if (is_lost) return call.stop_others(answers.outcome);
  if (answers.tick != 0) withdraw(call);
  if (!answers.outcome) return answers.outcome;
  return not_in_this_state("axis " + to_string(layout.axes[answers.ignored.front()]) +
                           " ignored the set-point: it is still moving, or a limit written after "
                           "enabling is not in force yet");
}

/// Withdraws a start in which not every axis took part: halts all axes, then gives them a set-point
/// at their present position. The halt also clears the common times, because the round that clears
/// them may be the one that was refused: left in force, they would make the next set-point of the
/// axis synchronous, even one of zero length.
void AxisGroup::State::withdraw(AxesCall& call) {
  Round halt = call.round_of(kHalt, every_axis);
  for (Round::Entry& entry : halt.entries) {
    add_object(entry.command, kDuration, 0);
    add_object(entry.command, kReferenceWay, 0);
  }
  const Answers halted = call.exchange({&halt, 1}, Timing::at_once);
  if (!call.steps() || is_on_the_move(call.snapshots())) {
    (void)call.await("standstill", halted.tick, [](const AxisSnapshot& axis) {
      return !is_enabled(axis) || stands_still(axis);
    });
  }
  std::array<Round, 2> rounds{call.round_of(kHalt, is_enabled),
                              call.round_of(kEnableOperation, is_enabled)};
  for (Round::Entry& entry : rounds[0].entries) {
    add_target(entry.command, call.snapshots()[entry.place].status.position_demand_value);
    add_word(entry.command, kHalt | Controlword::kNewSetPoint | Controlword::kChangeSetImmediately);
  }
  (void)call.exchange(rounds, Timing::at_once);  // the axis may refuse this too
}

bool AxisGroup::State::has_arrived(const ActiveLine& line, std::span<const AxisSnapshot> axes) {
  for (std::size_t place = 0; place < axes.size(); ++place) {
    if (!demand_arrived(axes[place], line.targets[place])) return false;
  }
  return true;
}

Outcome AxisGroup::State::await_line(AxesCall& call, const GroupCallOptions& options,
                                     bool in_position) {
  const auto moving = active_line();
  if (!moving) return {};
  call.set_timeout(options.timeout.value_or(moving->duration + kBeyondDuration));
  call.note_in_force(moving->start_tick);
  call.follow(moving->given);
  Outcome cut;
  Outcome outcome =
      call.await_enabled(in_position ? "target reached, bit 10" : "the arrival of the demand",
                         moving->start_tick, [&](std::size_t place) {
                           const AxisSnapshot& axis = call.snapshots()[place];
                           if (cut) cut = check_limit_switch(call, axis, moving->targets[place]);
                           return !cut || (demand_arrived(axis, moving->targets[place]) &&
                                           (!in_position || target_reached(axis)));
                         });
  // The axis has left the line: the others must not continue alone.
  if (outcome && !cut) outcome = call.stop_others(std::move(cut));
  if (outcome) {
    set_line(std::nullopt);
  } else if (outcome.kind() != OutcomeKind::timed_out) {
    drop_all();
  }
  return outcome;
}

Outcome AxisGroup::State::run(AxesCall& call, const LineRequest& request,
                              const GroupCallOptions& options) {
  if (is_on_the_move(call.snapshots())) {
    drop_queue();  // after a refusal the axes continue along the present line
  } else {
    drop_all();
  }
  if (Outcome started = start(call, request); !started) return started;
  if (options.until == Until::done) return await_line(call, options, true);
  return call.await_enabled("the start", active_line()->start_tick, every_axis);
}

Outcome AxisGroup::move_together(const Eigen::VectorXd& targets, const GroupMoveOptions& options) {
  const auto request = state_->request_of(targets, options);
  if (!request) return request.outcome();
  AxesCall call = state_->call(options.call);
  if (Outcome ready = call.begin_control(timeout_of(options.call)); !ready) return ready;
  return state_->explained(state_->run(call, *request, options.call));
}

Outcome AxisGroup::move_by(const Eigen::VectorXd& displacements, const GroupMoveOptions& options) {
  AxesCall call = state_->call(options.call);
  if (Outcome ready = call.begin_control(timeout_of(options.call)); !ready) return ready;
  Eigen::VectorXd targets = displacements;
  for (Eigen::Index i = 0; i < std::min<Eigen::Index>(targets.size(), std::ssize(call.snapshots()));
       ++i) {
    targets[i] += call.snapshots()[static_cast<std::size_t>(i)].status.position_demand_value;
  }
  const auto request = state_->request_of(targets, options);
  if (!request) return request.outcome();
  return state_->explained(state_->run(call, *request, options.call));
}

Outcome AxisGroup::queue_move(const Eigen::VectorXd& targets, const GroupMoveOptions& options) {
  const Discovery& discovery = state_->core->discovery;
  if (Outcome here = discovery.check_process(); !here) return here;
  // Nothing is sent: a bench that is briefly silent may still take the line later.
  for (const GroupLayout::Bench& bench : state_->layout.benches) {
    if (Outcome there = discovery.check_last_run(bench.number); !there) return there;
  }
  auto request = state_->request_of(targets, options);
  if (!request) return request.outcome();
  const std::scoped_lock lock(state_->mutex);
  state_->queue.push_back(std::move(*request));
  return {};
}

Outcome AxisGroup::wait_all(const GroupCallOptions& options) {
  AxesCall call = state_->call(options);
  if (Outcome ready = call.begin_control(timeout_of(options)); !ready) return ready;
  while (true) {
    bool last = false;
    {
      const std::scoped_lock lock(state_->mutex);
      last = state_->queue.empty();
    }
    if (Outcome arrived = state_->await_line(call, options, last); !arrived) {
      return state_->explained(std::move(arrived));
    }
    const auto next = state_->next_request();
    if (!next) return {};
    if (Outcome started = state_->start(call, *next); !started) {
      state_->drop_all();
      return state_->explained(std::move(started));
    }
  }
}

/// With a line in progress, waits for its end; otherwise waits as Axis::resume() does.
Outcome AxisGroup::State::resume(AxesCommand& resume, const GroupCallOptions& options) {
  if (stream) resume.release_streams_of(stream->released);
  std::set<std::uint32_t> stepped;
  resume.await_in_force(stepped);
  if (resume.outcome() && options.until == Until::done && active_line()) {
    return explained(await_line(resume.call(), options, true));
  }
  resume.finish();
  return explained(resume.outcome());
}

}  // namespace vdrive::client
