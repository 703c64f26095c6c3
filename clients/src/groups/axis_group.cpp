// SPDX-License-Identifier: Apache-2.0
// The axes of a group, their power states, and fault monitoring.
#include "vdrive/client/axis_group.hpp"

#include "base/drive_words.hpp"
#include "calls/axes_command.hpp"
#include "groups/group_state.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/wire/origin.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <utility>

namespace vdrive::client {
namespace {

// As for a single axis: longer than the moves that programs usually wait for.
constexpr std::chrono::seconds kUsualTimeout{60};

bool moves(const AxisSnapshot& axis) {
  const bool on_the_way = axis.mode() == OperatingMode::profile_position && !target_reached(axis);
  return on_the_way || axis.status.velocity_demand_value != 0;
}

GroupState state_of(const std::vector<AxisSnapshot>& axes) {
  const auto any = [&axes](const auto& question) {
    return std::ranges::any_of(axes, question, &AxisSnapshot::state);
  };
  if (any(is_fault)) return GroupState::error_stop;
  if (any([](PowerState state) {
        return state == PowerState::quick_stop_active;
      })) {
    return GroupState::stopping;
  }
  if (!std::ranges::all_of(axes, is_enabled)) return GroupState::disabled;
  return std::ranges::any_of(axes, moves) ? GroupState::moving : GroupState::standby;
}

/// The completed fraction of the present line, according to the axis with the longest distance.
double fraction_of(const ActiveLine& line, std::span<const AxisSnapshot> axes) {
  double longest = 0.0;
  double fraction = 1.0;
  for (std::size_t place = 0; place < axes.size(); ++place) {
    const double way = static_cast<double>(line.targets[place]) - line.starts[place];
    if (std::abs(way) <= longest) continue;
    longest = std::abs(way);
    fraction =
        (static_cast<double>(axes[place].status.position_demand_value) - line.starts[place]) / way;
  }
  return std::clamp(fraction, 0.0, 1.0);
}

Outcome check_axes(std::span<const AxisId> axes) {
  if (axes.empty()) return Outcome::not_found("a group needs at least one axis");
  std::set<AxisId> seen;
  std::map<std::uint32_t, std::size_t> counts;  // of axes, by bench
  for (const AxisId& id : axes) {
    if (!seen.insert(id).second) {
      return Outcome::refused(wire::number(msg::Reason::axis_twice),
                              "axis " + to_string(id) + " appears twice in the group");
    }
    if (++counts[id.bench] > msg::MAX_AXES_PER_FRAME) {
      return Outcome::refused(wire::number(msg::Reason::too_many_axes),
                              "axis " + to_string(id) + " is too many: a group can have " +
                                  std::to_string(msg::MAX_AXES_PER_FRAME) + " axes of one bench");
    }
  }
  return {};
}

Eigen::VectorXd vector_of(const std::vector<AxisSnapshot>& axes, std::int32_t AxisStatus::*member) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(axes.size()));
  for (std::size_t place = 0; place < axes.size(); ++place) {
    values[static_cast<Eigen::Index>(place)] = axes[place].status.*member;
  }
  return values;
}

bool is_factor(double factor) {
  return factor > 0.0 && factor <= 1.0;
}

}  // namespace

std::string_view to_string(GroupState state) noexcept {
  switch (state) {
    case GroupState::disabled:
      return "disabled";
    case GroupState::standby:
      return "standby";
    case GroupState::moving:
      return "moving";
    case GroupState::stopping:
      return "stopping";
    case GroupState::error_stop:
      return "error_stop";
  }
  return "unknown";
}

Eigen::VectorXd GroupStatus::demand() const {
  return vector_of(axes, &AxisStatus::position_demand_value);
}

Eigen::VectorXd GroupStatus::actual() const {
  return vector_of(axes, &AxisStatus::load_position_actual_value);
}

std::vector<AxisId> GroupStatus::not_following() const {
  std::vector<AxisId> late;
  for (const AxisSnapshot& axis : axes) {
    if (!axis.shows(Statusword::kFollowsCommand)) late.push_back(axis.id);
  }
  return late;
}

// ---- state shared by copies --------------------------------------------------------------------

std::chrono::nanoseconds timeout_of(const GroupCallOptions& options) {
  return options.timeout.value_or(kUsualTimeout);
}

Outcome AxisGroup::State::explained(Outcome outcome) const {
  return explain_loss(*core, std::move(outcome), layout.axes);
}

AxesCall AxisGroup::State::call(const GroupCallOptions& options) {
  return {core, layout, Caller::group, progress_of(options)};
}

ObservedAxes::Progress AxisGroup::State::progress_of(const GroupCallOptions& options) {
  if (!options.progress) return {};
  return
      [this, progress = options.progress](std::uint64_t tick, std::span<const AxisSnapshot> axes) {
        const auto moving = active_line();
        progress({tick, moving ? fraction_of(*moving, axes) : 0.0, axes});
      };
}

Result<std::vector<std::int32_t>> AxisGroup::State::set_points_of(const Eigen::VectorXd& values,
                                                                  const StreamedRow& row) const {
  if (static_cast<std::size_t>(values.size()) != layout.axes.size()) {
    const bool is_velocity = row.what == Streamed::velocities;
    return Outcome::refused(wire_code(AbortCode::data_length_does_not_match),
                            std::to_string(values.size()) + " " +
                                (is_velocity ? "velocities" : std::string(row.noun) + "s") +
                                " for " + std::to_string(layout.axes.size()) + " axes");
  }
  const ObjectDescription& object = vdrive::describe(row.object);
  const auto lowest = static_cast<double>(object.lower_limit);
  const auto highest = static_cast<double>(object.upper_limit);
  std::vector<std::int32_t> set_points;
  for (const double value : values) {
    const double whole = std::nearbyint(value);
    if (!(whole >= lowest && whole <= highest)) {  // also rejects NaN
      return Outcome::refused(wire_code(AbortCode::value_range_exceeded),
                              "axis " + to_string(layout.axes[set_points.size()]) + ": the " +
                                  std::string(row.noun) + " " + std::to_string(value) +
                                  " does not fit in " +
                                  std::to_string(8 * size_of(object.data_type)) + " bits");
    }
    set_points.push_back(static_cast<std::int32_t>(whole));
  }
  return set_points;
}

Result<LineRequest> AxisGroup::State::request_of(const Eigen::VectorXd& targets,
                                                 const GroupMoveOptions& options) const {
  if (!is_factor(options.velocity_factor) || !is_factor(options.acceleration_factor) ||
      !is_factor(options.deceleration_factor)) {
    return Outcome::refused(wire_code(AbortCode::value_range_exceeded),
                            "the factors of a move must be above 0 and at most 1");
  }
  auto positions = set_points_of(targets, kStreamedRows.front());
  if (!positions) return positions.outcome();
  return LineRequest{.targets = std::move(*positions),
                     .velocity_factor = options.velocity_factor,
                     .acceleration_factor = options.acceleration_factor,
                     .deceleration_factor = options.deceleration_factor};
}

std::optional<ActiveLine> AxisGroup::State::active_line() {
  const std::scoped_lock lock(mutex);
  return line;
}

void AxisGroup::State::set_line(std::optional<ActiveLine> started) {
  const std::scoped_lock lock(mutex);
  line = std::move(started);
}

std::optional<LineRequest> AxisGroup::State::next_request() {
  const std::scoped_lock lock(mutex);
  if (queue.empty()) return std::nullopt;
  LineRequest next = std::move(queue.front());
  queue.pop_front();
  return next;
}

void AxisGroup::State::drop_queue() {
  const std::scoped_lock lock(mutex);
  queue.clear();
}

void AxisGroup::State::drop_all() {
  const std::scoped_lock lock(mutex);
  line.reset();
  queue.clear();
}

GroupStatus AxisGroup::State::status_of(const AxesCall& call) {
  const std::scoped_lock lock(mutex);
  GroupStatus status{.tick = call.tick(),
                     .state = state_of(call.snapshots()),
                     .queued = queue.size(),
                     .axes = call.snapshots()};
  const bool is_due = line && call.tick() < line->start_tick;
  if (is_due && status.state == GroupState::standby) status.state = GroupState::moving;
  return status;
}

// ---- axes --------------------------------------------------------------------------------------

AxisGroup::AxisGroup(std::shared_ptr<State> state) : state_(std::move(state)) {}

Result<AxisGroup> AxisGroup::create(Session& session, std::span<const std::string> axes) {
  session.core_->failure.rethrow();
  std::vector<Axis> found;
  for (const std::string& text : axes) {
    auto info = session.core_->discovery.find_axis(text);
    if (!info) return info.outcome();
    found.push_back(Axis(session.core_, std::move(*info)));
  }
  return create(session, found);
}

Result<AxisGroup> AxisGroup::create(Session& session, std::span<const Axis> axes) {
  std::vector<AxisId> ids;
  for (const Axis& axis : axes) {
    if (axis.core_ != session.core_) {
      return Outcome::refused(wire::number(msg::Reason::bad_session),
                              "axis " + to_string(axis.id()) + " belongs to another session");
    }
    ids.push_back(axis.id());
  }
  if (Outcome sound = check_axes(ids); !sound) return sound;
  auto state = wire::made_here<State>();
  state->core = session.core_;
  state->layout = layout_of(ids);
  AxisGroup group(std::move(state));
  if (auto shown = group.status(); !shown) return shown.outcome();
  return group;
}

std::vector<AxisId> AxisGroup::axes() const {
  return state_->layout.axes;
}

Result<GroupStatus> AxisGroup::status() const {
  AxesCall call = state_->call({});
  if (Outcome begun = call.begin(kUsualTimeout); !begun) return begun;
  return state_->status_of(call);
}

// ---- commands --------------------------------------------------------------------------------

Outcome AxisGroup::command(EachCommand command, const GroupCallOptions& options) {
  AxesCommand all(
      state_->core, state_->layout, Caller::group, command,
      {.timeout = timeout_of(options), .until = options.until, .keep_target = options.keep_target},
      state_->progress_of(options));
  all.begin();
  const bool ends_line = command == EachCommand::disable || command == EachCommand::quick_stop ||
                         command == EachCommand::power_cycle;
  if (ends_line && all.outcome()) state_->drop_all();
  if (command == EachCommand::resume) return state_->resume(all, options);
  all.carry_out();
  return state_->explained(all.outcome());
}

Outcome AxisGroup::enable_all(const GroupCallOptions& options) {
  return command(EachCommand::enable, options);
}

Outcome AxisGroup::disable_all(const GroupCallOptions& options) {
  return command(EachCommand::disable, options);
}

Outcome AxisGroup::halt_all(const GroupCallOptions& options) {
  return command(EachCommand::halt, options);
}

Outcome AxisGroup::resume_all(const GroupCallOptions& options) {
  return command(EachCommand::resume, options);
}

Outcome AxisGroup::quick_stop_all(const GroupCallOptions& options) {
  return command(EachCommand::quick_stop, options);
}

Outcome AxisGroup::reset_all(const GroupCallOptions& options) {
  return command(EachCommand::reset_fault, options);
}

Outcome AxisGroup::take_over() {
  AxesCall call = state_->call({});
  if (Outcome begun = call.begin(kUsualTimeout); !begun) return begun;
  return call.acquire(true);
}

// ---- monitoring --------------------------------------------------------------------------------

/// Stops the enabled axes if any axis has a fault or, during a line, is not enabled or belongs to
/// another session.
Outcome AxisGroup::State::watch(AxesCall& call) {
  const auto moving = active_line();
  if (moving && call.tick() < moving->start_tick) return {};
  Answers stop;
  if (moving) {
    call.note_owned();
    if (Outcome own = call.check_owners(); !own) {
      drop_all();
      return call.send_stop(std::move(own), stop);
    }
  }
  const auto failed = std::ranges::find_if(call.snapshots(), [&moving](const AxisSnapshot& axis) {
    return is_fault(axis.state()) || (moving && !is_enabled(axis));
  });
  if (failed == call.snapshots().end()) return {};
  if (!moving && std::ranges::none_of(call.snapshots(), is_enabled)) return {};
  drop_all();
  return call.send_stop(
      Outcome::failed("axis " + to_string(failed->id) + " " + what_it_shows(*failed)), stop);
}

Outcome AxisGroup::State::watch_commands(AxesCall& call) {
  const auto moving = active_line();
  if (!moving || call.tick() < moving->start_tick) return {};
  call.follow(moving->given);
  for (std::size_t place = 0; place < call.snapshots().size(); ++place) {
    Outcome sound = call.check_command("the end of the line", place);
    if (sound) continue;
    drop_all();
    Answers stop;
    return call.send_stop(std::move(sound), stop);
  }
  return {};
}

Result<GroupStatus> AxisGroup::poll() {
  AxesCall call = state_->call({});
  if (Outcome begun = call.begin(kUsualTimeout); !begun) return begun;
  Outcome sound = state_->watch(call);
  if (sound) sound = state_->watch_commands(call);
  if (!sound) return state_->explained(call.explain_lost_power(sound));
  const auto moving = state_->active_line();
  const bool at_rest = !moving || (call.tick() >= moving->start_tick &&
                                   state_->has_arrived(*moving, call.snapshots()));
  if (at_rest) {
    state_->set_line(std::nullopt);
    if (const auto next = state_->next_request()) {
      Outcome started = call.acquire();
      if (started) started = state_->start(call, *next);
      if (!started) {
        state_->drop_all();
        return state_->explained(std::move(started));
      }
    }
  }
  return state_->status_of(call);
}

Outcome AxisGroup::monitor(bool on) {
  if (Outcome here = state_->core->discovery.check_process(); !here) return here;
  state_->monitor = {};
  if (!on) return {};
  AxesCall call = state_->call({});
  if (Outcome begun = call.begin(kUsualTimeout); !begun) return begun;
  if (call.steps()) {
    return Outcome::refused(wire::number(msg::Reason::wrong_clock_mode),
                            "monitor() needs a clock that is not stepped: realtime or freerun; in "
                            "lock-step use poll()");
  }
  state_->monitor = std::jthread(
      [state = state_.get(), watched = std::move(call)](const std::stop_token& stop) mutable {
        state->monitor_loop(stop, watched);
      });
  return {};
}

void AxisGroup::State::monitor_loop(const std::stop_token& stop, AxesCall& call) {
  call.axes().stop_by(stop);
  while (!stop.stop_requested()) {
    (void)watch(call);
    if (Outcome seen = call.axes().advance(1); !seen) {
      Answers answers;
      if (seen.kind() == OutcomeKind::lost) (void)call.send_stop(std::move(seen), answers);
      return;
    }
  }
}

}  // namespace vdrive::client
