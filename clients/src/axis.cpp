// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/axis.hpp"

#include "arrival.hpp"
#include "axes_call.hpp"
#include "axes_stop.hpp"
#include "command_words.hpp"
#include "profile_move.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace vdrive::client {
namespace {

constexpr std::string_view kQuickStopEnd = "the quick stop to end";

/// Sets profile position mode and waits until 6061h shows it.
Outcome ensure_profile_position(AxesCall& call) {
  if (call.axis().mode() == OperatingMode::profile_position) return {};
  Round round = call.round_to(every_axis);
  msg::AxisCommand& command = round.entries.front().command;
  command.members(msg::HAS_OP_MODE_CMD);
  command.op_mode_cmd(static_cast<std::int8_t>(OperatingMode::profile_position));
  if (Outcome done = call.put_in_force({&round, 1}); !done) return done;
  return call.await_enabled("profile position mode", call.tick(), [](const AxisSnapshot& axis) {
    return axis.mode() == OperatingMode::profile_position;
  });
}

msg::ObjectAccess access_of(const AxisId& id, ObjectAddress object, std::int64_t value = 0) {
  msg::ObjectAccess access;
  access.axis(id.axis);
  access.index(object.index);
  access.subindex(object.subindex);
  access.value(value);
  return access;
}

std::string name_of(ObjectAddress object) {
  const auto row = find_object(object);
  if (row) return std::string(vdrive::describe(*row).variable_name);
  return hex(object.index, 4) + ":" + std::to_string(object.subindex);
}

}  // namespace

Axis::Axis(std::shared_ptr<SessionCore> core, AxisId id, std::string name)
    : core_(std::move(core)), id_(id), name_(std::move(name)) {}

Result<AxisSnapshot> Axis::status() const {
  const auto target = core_->connection.connect(id_.bench);
  if (!target) return target.outcome();
  const std::array axes{id_.axis};
  auto seen = core_->observer.observe(*target, axes);
  if (!seen) return seen.outcome();
  return seen->axes.front();
}

Outcome Axis::acquire() {
  const auto target = core_->connection.connect(id_.bench);
  if (!target) return target.outcome();
  return core_->control.acquire(*target, {&id_.axis, 1});
}

Outcome Axis::take_over() {
  const auto target = core_->connection.connect(id_.bench);
  if (!target) return target.outcome();
  return core_->control.acquire(*target, {&id_.axis, 1}, true);
}

Outcome Axis::enable(const CallOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = call.begin_control(options.timeout); !ready) return ready;
  if (is_fault(call.axis().state())) {
    return refused_in_state(call.axis(), "enabling", "a fault reset first");
  }
  if (call.axis().state() == PowerState::operation_enabled) return {};
  if (call.axis().state() == PowerState::quick_stop_active && options.until == Until::done) {
    if (Outcome rested = call.await_quick_stops(kQuickStopEnd); !rested) return rested;
  }
  if (Outcome done = call.put_in_force(enabling_words(call.axis().state())); !done) return done;
  if (call.axis().state() == PowerState::operation_enabled) return {};
  return failed_instead_of("Operation enabled", call.axis());
}

Outcome Axis::disable(const CallOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = call.begin_control(options.timeout); !ready) return ready;
  if (is_fault(call.axis().state())) {
    return refused_in_state(call.axis(), "disabling", "a fault reset first");
  }
  if (call.axis().state() == PowerState::quick_stop_active) {
    if (Outcome rested = call.await_quick_stops(kQuickStopEnd); !rested) return rested;
    // Where 605Ah keeps the state.
    if (Outcome done = call.put_in_force({kDisableVoltage}); !done) return done;
  }
  if (Outcome done = call.put_in_force({kShutdown}); !done) return done;
  if (options.until == Until::in_force) return {};
  Outcome seen = call.await("Ready to switch on", call.tick(), [](const AxisSnapshot& axis) {
    return axis.state() == PowerState::ready_to_switch_on || is_fault(axis.state());
  });
  if (!seen || !is_fault(call.axis().state())) return seen;
  return failed_instead_of("Ready to switch on", call.axis());
}

Outcome Axis::move_to(std::int32_t position, const MoveOptions& options) {
  return move(position, false, options);
}

Outcome Axis::move_by(std::int32_t distance, const MoveOptions& options) {
  return move(distance, true, options);
}

Outcome Axis::move(std::int32_t target, bool relative, const MoveOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = call.begin_control(options.call.timeout); !ready) return ready;
  if (call.axis().state() != PowerState::operation_enabled) {
    return refused_in_state(call.axis(), "a move", "Operation enabled");
  }
  ProfileMove move(call, core_->wakeup, options);
  if (Outcome ready = move.prepare(); !ready) return ready;
  if (Outcome moded = ensure_profile_position(call); !moded) return moded;
  if (Outcome taken = move.start(target, relative); !taken) return taken;
  if (options.call.until == Until::done) {
    if (Outcome reached = move.await_target(); !reached) return reached;
  }
  return move.finish();
}

Result<Motion> Axis::start_move(std::int32_t position, const MoveOptions& options) {
  MoveOptions start = options;
  start.call.until = Until::in_force;
  if (Outcome started = move(position, false, start); !started) return started;
  return Motion(*this);
}

Outcome Motion::wait(std::chrono::nanoseconds timeout) const {
  AxesCall call(axis_.core_, layout_of(axis_.id_), Caller::axis);
  if (Outcome ready = call.begin(timeout); !ready) return ready;
  return await_target(call, axis_.core_->wakeup);
}

Result<bool> Motion::has_ended() const {
  AxesCall call(axis_.core_, layout_of(axis_.id_), Caller::axis);
  if (Outcome ready = call.begin(std::chrono::nanoseconds(0)); !ready) return ready;
  if (!is_enabled(call.axis())) return failed_instead_of(kTargetReached, call.axis());
  if (!target_reached(call.axis())) return false;
  if (Outcome ended = check_halt(call); !ended) return ended;
  return true;
}

Outcome Axis::halt(const CallOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  AxesStop stop(*core_, call);
  if (Outcome ready = stop.begin(options.timeout); !ready) return ready;
  if (call.axis().state() != PowerState::operation_enabled) {
    return refused_in_state(call.axis(), "a halt", "Operation enabled");
  }
  if (Outcome taken = stop.acquire_free(); !taken) return taken;
  if (Outcome done = stop.put_in_force(kHalt); !done) return done;
  if (options.until == Until::in_force) return {};
  return call.await_enabled("standstill, bit 10", call.tick(), target_reached);
}

Outcome Axis::resume(const CallOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = call.begin_control(options.timeout); !ready) return ready;
  if (call.axis().state() != PowerState::operation_enabled) {
    return refused_in_state(call.axis(), "resuming", "Operation enabled");
  }
  if (Outcome done = call.put_in_force({kEnableOperation}); !done) return done;
  if (options.until == Until::in_force) return {};
  return await_target(call, core_->wakeup);
}

Outcome Axis::quick_stop(const CallOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  AxesStop stop(*core_, call);
  if (Outcome ready = stop.begin(options.timeout); !ready) return ready;
  if (is_fault(call.axis().state())) {
    return refused_in_state(call.axis(), "a quick stop", "a fault reset first");
  }
  if (Outcome done = stop.put_in_force(kQuickStop); !done) return done;
  if (options.until == Until::in_force) return {};
  if (Outcome rested = call.await_quick_stops(kQuickStopEnd); !rested) return rested;
  return is_fault(call.axis().state()) ? failed_instead_of(kQuickStopEnd, call.axis()) : Outcome();
}

Outcome Axis::reset_fault(const CallOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = call.begin_control(options.timeout); !ready) return ready;
  if (!is_fault(call.axis().state())) return {};
  Outcome reacted =
      call.await("the fault reaction to end", call.tick(), [](const AxisSnapshot& axis) {
        return axis.state() != PowerState::fault_reaction_active;
      });
  if (!reacted) return reacted;
  if (Outcome done = call.put_in_force(reset_words()); !done) return done;
  if (!is_fault(call.axis().state())) return {};
  return not_in_this_state(failed_instead_of("the end of the fault", call.axis()).message() +
                           ", the cause persists");
}

Outcome Axis::power_cycle(const CallOptions& options) {
  AxesCall call(core_, layout_of(id_), Caller::axis);
  if (Outcome ready = call.begin(options.timeout); !ready) return ready;
  msg::Request request;
  request.kind(msg::REQUEST_POWER_CYCLE);
  request.axes().push_back(id_.axis);
  const auto reply = core_->control.exchange(call.axes().parts().front().target, std::move(request),
                                             "power cycle of axis " + to_string(id_));
  if (!reply) return reply.outcome();
  if (options.until == Until::in_force) return {};
  if (Outcome seen = call.await_tick("the power-up", std::max(reply->tick(), call.axis().tick + 1));
      !seen) {
    return seen;
  }
  Outcome seen = call.await("Switch on disabled", call.tick(), [](const AxisSnapshot& axis) {
    return axis.state() == PowerState::switch_on_disabled || is_fault(axis.state());
  });
  if (!seen || !is_fault(call.axis().state())) return seen;
  return failed_instead_of("Switch on disabled", call.axis());
}

Outcome Axis::store() {
  return request_memory(msg::REQUEST_STORE, "storing the parameters of axis " + to_string(id_));
}

Outcome Axis::restore_defaults() {
  return request_memory(msg::REQUEST_RESTORE, "restoring the defaults of axis " + to_string(id_));
}

Outcome Axis::request_memory(std::uint32_t kind, const std::string& what) {
  const auto target = core_->connection.connect(id_.bench);
  if (!target) return target.outcome();
  msg::Request request;
  request.kind(kind);
  request.axes().push_back(id_.axis);
  Outcome outcome = core_->requests.exchange(*target, std::move(request), what).outcome();
  if (outcome.code() != wire_code(AbortCode::cannot_store_or_transfer)) return outcome;
  return Outcome::refused(outcome.code(), what +
                                              " refused, the service has no state directory (start "
                                              "vdrived with --state DIR)");
}

Result<Readings> Axis::read(std::span<const ObjectAddress> objects) const {
  const auto target = core_->connection.connect(id_.bench);
  if (!target) return target.outcome();
  Readings readings;
  for (std::size_t first = 0; first < objects.size(); first += msg::MAX_OBJECTS_PER_REQUEST) {
    const auto part = objects.subspan(
        first, std::min<std::size_t>(msg::MAX_OBJECTS_PER_REQUEST, objects.size() - first));
    msg::Request request;
    request.kind(msg::REQUEST_READ);
    for (const ObjectAddress& object : part) request.objects().push_back(access_of(id_, object));
    const auto reply =
        core_->requests.exchange(*target, std::move(request), "read of axis " + to_string(id_));
    if (!reply) return reply.outcome();
    if (reply->objects().size() != part.size()) {
      return Outcome::failed("the read of axis " + to_string(id_) + " was answered only in part");
    }
    readings.tick = reply->tick();
    for (const msg::ObjectResult& result : reply->objects()) {
      readings.objects.push_back({.object = {result.index(), result.subindex()},
                                  .code = static_cast<AbortCode>(result.abort_code()),
                                  .value = result.value()});
    }
  }
  return readings;
}

Result<std::int64_t> Axis::read(ObjectAddress object) const {
  const auto readings = read(std::span(&object, 1));
  if (!readings) return readings.outcome();
  const ObjectReading& reading = readings->objects.front();
  if (reading.code == AbortCode::none) return reading.value;
  return Outcome::refused(wire_code(reading.code),
                          "read of " + name_of(object) + " of axis " + to_string(id_) + " refused");
}

Result<std::uint64_t> Axis::write(ObjectAddress object, std::int64_t value) {
  const auto target = core_->connection.connect(id_.bench);
  if (!target) return target.outcome();
  msg::Request request;
  request.kind(msg::REQUEST_WRITE);
  request.objects().push_back(access_of(id_, object, value));
  const std::string what =
      "write of " + std::to_string(value) + " to " + name_of(object) + " of axis " + to_string(id_);
  const auto reply = core_->control.write(*target, std::move(request), what);
  if (!reply) return reply.outcome();
  for (const msg::ObjectResult& result : reply->objects()) {
    if (result.abort_code() != 0) return Outcome::refused(result.abort_code(), what + " refused");
  }
  return reply->tick();
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
  return call.axis();
}

}  // namespace vdrive::client
