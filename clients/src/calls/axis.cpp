// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/axis.hpp"

#include "base/ask.hpp"
#include "base/drive_words.hpp"
#include "calls/arrival.hpp"
#include "calls/axes_command.hpp"
#include "calls/profile_move.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/quantity.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace vdrive::client {

/// The state that a Motion is checked against.
struct StartedMove {
  BenchKey bench;
  GivenCommand given;       ///< the set-point
  std::uint64_t tick = 0;   ///< the drive has it in this tick or earlier
  std::int32_t target = 0;  ///< [UU]
};

namespace {

/// Sets profile position mode and waits until 6061h shows it.
Outcome ensure_profile_position(AxesCall& call) {
  if (call.snapshot().mode() == OperatingMode::profile_position) return {};
  Round round = call.round_to(every_axis);
  msg::AxisCommand& command = round.entries.front().command;
  command.members = msg::HAS_OP_MODE_CMD;
  command.op_mode_cmd = static_cast<std::int8_t>(OperatingMode::profile_position);
  if (Outcome done = call.put_in_force({&round, 1}); !done) return done;
  return call.await_enabled("profile position mode", call.tick(), [](const AxisSnapshot& axis) {
    return axis.mode() == OperatingMode::profile_position;
  });
}

/// @param what the refused value or action; the message adds which values the object accepts
Outcome refused(ObjectAddress object, std::uint32_t code, const std::string& what,
                const Unit& unit) {
  const std::string advice = advice_on(object, static_cast<AbortCode>(code), unit);
  return Outcome::refused(code, what + " refused" + (advice.empty() ? "" : ", " + advice));
}

/// A request about the stored parameters of an axis.
Outcome exchange_memory(SessionCore& core, const AxisId& id, msg::Request request,
                        const std::string& what) {
  const auto target = core.links.connect(id.bench);
  if (!target) return target.outcome();
  Outcome outcome = core.exchange.request(*target, std::move(request), what).outcome();
  if (outcome.code() != wire_code(AbortCode::cannot_store_or_transfer)) {
    return core.names.with_session_name(*target, std::move(outcome));
  }
  return Outcome::refused(
      outcome.code(),
      what +
          " refused, the bench has no state directory: start vdrived with --state DIR; for a "
          "bench in a process BenchOptions::state_directory, in Python state=");
}

}  // namespace

Axis::Axis(std::shared_ptr<SessionCore> core, AxisInfo info)
    : core_(std::move(core)),
      id_(info.id),
      name_(std::move(info.name)),
      unit_(std::move(info.unit)) {}

Result<AxisSnapshot> Axis::status() const {
  const auto target = core_->links.connect(id_.bench);
  if (!target) return target.outcome();
  const std::array axes{id_.axis};
  auto seen = core_->observer.observe(*target, axes);
  if (!seen) return seen.outcome();
  return seen->axes.front();
}

Outcome Axis::acquire() {
  const auto target = core_->links.connect(id_.bench);
  if (!target) return target.outcome();
  return core_->names.with_session_name(*target, core_->control.acquire(*target, {&id_.axis, 1}));
}

Outcome Axis::take_over() {
  const auto target = core_->links.connect(id_.bench);
  if (!target) return target.outcome();
  return core_->names.with_session_name(*target,
                                        core_->control.acquire(*target, {&id_.axis, 1}, true));
}

Outcome Axis::command(EachCommand command, const CallOptions& options) {
  return command_each(core_, {&id_, 1}, command, options).front();
}

Outcome Axis::enable(const CallOptions& options) {
  return command(EachCommand::enable, options);
}

Outcome Axis::disable(const CallOptions& options) {
  return command(EachCommand::disable, options);
}

Outcome Axis::move_to(std::int32_t position, const MoveOptions& options) {
  return explain_loss(*core_, move(position, false, options), {&id_, 1});
}

Outcome Axis::move_by(std::int32_t distance, const MoveOptions& options) {
  return explain_loss(*core_, move(distance, true, options), {&id_, 1});
}

Outcome Axis::move(std::int32_t target, bool relative, const MoveOptions& options,
                   StartedMove* started) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = call.begin_control(options.call.timeout, kMoveObjects); !ready) return ready;
  if (Outcome able = call.require(is_enabled, "a move", "Operation enabled"); !able) return able;
  ProfileMove move(call, core_->wakeup, options);
  if (Outcome ready = move.prepare(); !ready) return ready;
  if (Outcome moded = ensure_profile_position(call); !moded) return moded;
  if (Outcome taken = move.start(target, relative); !taken) return taken;
  if (options.call.until == Until::done) {
    if (Outcome reached = move.await_target(); !reached) return reached;
  }
  if (started != nullptr) {
    *started = {.bench = call.axes().parts().front().target.key,
                .given = call.given().front(),
                .tick = call.tick(),
                .target = target};
  }
  return move.finish();
}

Result<Motion> Axis::start_move(std::int32_t position, const MoveOptions& options) {
  MoveOptions start = options;
  start.call.until = Until::in_force;
  const auto started = wire::made_here<StartedMove>();
  Outcome taken = explain_loss(*core_, move(position, false, start, started.get()), {&id_, 1});
  if (!taken) return taken;
  return Motion(*this, started);
}

namespace {

/// How long Motion::has_ended() waits for a sample: drive time, or wall time if drive time does not
/// pass.
constexpr std::chrono::seconds kOldSample{1};

/// Connects and starts the wait for the move.
Outcome begin_to_follow(AxesCall& call, const StartedMove& move, std::chrono::nanoseconds timeout) {
  if (Outcome ready = call.begin(timeout); !ready) return ready;
  const Target& target = call.axes().parts().front().target;
  if (target.key != move.bench) return Outcome::lost(restarted_text(target));
  call.follow({move.given});
  return {};
}

}  // namespace

Outcome Motion::wait(std::chrono::nanoseconds timeout) const {
  AxesCall call(axis_.core_, layout_of(axis_.id_), Caller::axis);
  if (Outcome ready = begin_to_follow(call, *move_, timeout); !ready) return ready;
  Outcome reached = await_target(call, axis_.core_->wakeup, move_->target, move_->tick);
  if (reached) reached = check_arrival(call, call.snapshot(), move_->target);
  return explain_loss(*axis_.core_, std::move(reached), {&axis_.id_, 1});
}

Result<bool> Motion::has_ended() const {
  AxesCall call(axis_.core_, layout_of(axis_.id_), Caller::axis);
  if (Outcome ready = begin_to_follow(call, *move_, kOldSample); !ready) return ready;
  if (Outcome seen = call.await_tick("a sample of the move", move_->tick); !seen) return seen;
  if (Outcome sound = call.check(kTargetReached, move_->tick); !sound) {
    return explain_loss(*axis_.core_, std::move(sound), {&axis_.id_, 1});
  }
  if (Outcome sound = check_set_point(call.snapshot()); !sound) return sound;
  if (!target_reached(call.snapshot())) {
    if (Outcome ended = check_limit_switch(call, call.snapshot(), move_->target); !ended)
      return ended;
    return false;
  }
  if (Outcome ended = check_halt(call); !ended) return ended;
  if (Outcome ended = check_arrival(call, call.snapshot(), move_->target); !ended) return ended;
  return true;
}

Outcome Axis::halt(const CallOptions& options) {
  return command(EachCommand::halt, options);
}

Outcome Axis::resume(const CallOptions& options) {
  return command(EachCommand::resume, options);
}

Outcome Axis::quick_stop(const CallOptions& options) {
  return command(EachCommand::quick_stop, options);
}

Outcome Axis::reset_fault(const CallOptions& options) {
  return command(EachCommand::reset_fault, options);
}

Outcome Axis::power_cycle(const CallOptions& options) {
  return command(EachCommand::power_cycle, options);
}

Outcome Axis::store() {
  return exchange_memory(*core_, id_, ask::store({id_.axis}),
                         "storing the parameters of axis " + to_string(id_));
}

Outcome Axis::restore_defaults() {
  return exchange_memory(*core_, id_, ask::restore({id_.axis}),
                         "restoring the defaults of axis " + to_string(id_));
}

Result<Readings> Axis::read(std::span<const ObjectAddress> objects) const {
  const auto target = core_->links.connect(id_.bench);
  if (!target) return target.outcome();
  Readings readings;
  for (std::size_t first = 0; first < objects.size(); first += kMostObjectsAtOnce) {
    const auto part = objects.subspan(first, std::min(kMostObjectsAtOnce, objects.size() - first));
    ask::Objects asked;
    for (const ObjectAddress& object : part) asked.push_back(ask::object(id_.axis, object));
    const auto reply = core_->exchange.request(*target, ask::read(std::move(asked)),
                                               "read of axis " + to_string(id_));
    if (!reply) return reply.outcome();
    if (reply->objects.size() != part.size()) {
      return Outcome::failed("the read of axis " + to_string(id_) + " was answered only in part");
    }
    readings.tick = reply->tick;
    for (const msg::ObjectResult& result : reply->objects) {
      readings.objects.push_back({.object = {result.index, result.subindex},
                                  .code = static_cast<AbortCode>(result.abort_code),
                                  .value = result.value});
    }
  }
  return readings;
}

Result<std::int64_t> Axis::read(ObjectAddress object) const {
  const auto readings = read(std::span(&object, 1));
  if (!readings) return readings.outcome();
  const ObjectReading& reading = readings->objects.front();
  if (reading.code == AbortCode::none) return reading.value;
  return refused(object, wire_code(reading.code),
                 "read of " + object_text(object) + " of axis " + to_string(id_), unit_);
}

Outcome Axis::check_velocity_limits(std::int64_t velocity) const {
  using namespace literals;
  const auto app_speed_limit = read(kObjectRows["app_speed_limit"_object].address);
  if (!app_speed_limit) return app_speed_limit.outcome();
  const auto motor_speed_limit = read(kObjectRows["motor_speed_limit"_object].address);
  if (!motor_speed_limit) return motor_speed_limit.outcome();
  return check_speed(
      id_, unit_, velocity,
      {.app_speed_limit = *app_speed_limit, .motor_speed_limit = *motor_speed_limit});
}

Result<std::uint64_t> Axis::write(ObjectAddress object, std::int64_t value) {
  const auto target = core_->links.connect(id_.bench);
  if (!target) return target.outcome();
  const auto row = find_object(object);
  const std::string what = "write of " +
                           (row ? object_value_text(*row, value, unit_) : std::to_string(value)) +
                           " to " + object_text(object) + " of axis " + to_string(id_);
  const auto reply =
      core_->control.write(*target, ask::write({ask::object(id_.axis, object, value)}), what);
  if (!reply) return core_->names.with_session_name(*target, reply.outcome());
  for (const msg::ObjectResult& result : reply->objects) {
    if (result.abort_code == msg::Reason::none) continue;
    const Outcome refusal = refused(object, wire::number(result.abort_code), what, unit_);
    const bool is_controlled =
        wire::number(result.abort_code) == wire_code(AbortCode::refused_local_control) &&
        reply->owner_session != 0 && reply->owner_session != core_->id;
    if (!is_controlled) return refusal;
    return core_->names.with_session_name(
        *target, refusal.with_owner({.axis = id_, .session = reply->owner_session}));
  }
  return reply->tick;
}

Result<std::uint64_t> Axis::disturb(Disturbance disturbance, std::int64_t value) {
  const auto row = std::ranges::find(kDisturbances, disturbance, &DisturbanceRow::disturbance);
  ensure(row != kDisturbances.end(), "every disturbance has a row");
  return write(vdrive::describe(*find_object(row->variable_name)).address, value);
}

Outcome Axis::end_disturbances() {
  for (const DisturbanceRow& row : kDisturbances) {
    if (const auto ended = disturb(row.disturbance, 0); !ended) return ended.outcome();
  }
  return {};
}

Result<AxisSnapshot> Axis::wait_until(const std::function<bool(const AxisSnapshot&)>& condition,
                                      std::chrono::nanoseconds timeout) const {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = call.begin(timeout); !ready) return ready;
  if (Outcome seen = call.await("the condition", call.tick(), condition); !seen) return seen;
  return call.snapshot();
}

}  // namespace vdrive::client
