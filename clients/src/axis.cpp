// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/axis.hpp"

#include "command_words.hpp"
#include "conversation.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>

namespace vdrive::client {
namespace {

/// Lets a quick stop end, or come to rest where 605Ah keeps the state.
Outcome await_quick_stop(Conversation& talk) {
  using namespace literals;
  const auto option = talk.read(vdrive::describe("quick_stop_option_code"_object).address);
  if (!option) return option.outcome();
  return talk.look_until("the quick stop to end", [&option](const AxisSnapshot& axis) {
    return quick_stop_ended(axis, *option);
  });
}

/// Sets profile position mode and waits until 6061h shows it.
Outcome ensure_profile_position(Conversation& talk) {
  if (talk.now().mode() == OperatingMode::profile_position) return {};
  msg::AxisCommand command;
  command.axis(talk.id().axis);
  command.members(msg::HAS_OP_MODE_CMD);
  command.op_mode_cmd(static_cast<std::int8_t>(OperatingMode::profile_position));
  if (Outcome said = talk.say({&command, 1}); !said) return said;
  return talk.look_enabled_until("profile position mode", [](const AxisSnapshot& axis) {
    return axis.mode() == OperatingMode::profile_position;
  });
}

msg::AxisCommand set_point(std::uint16_t axis, std::int32_t target, bool relative,
                           const MoveOptions& options) {
  std::uint16_t word = kEnableOperation | Controlword::kNewSetPoint;
  if (!options.queue) word |= Controlword::kChangeSetImmediately;
  if (relative) word |= Controlword::kRelative;
  msg::AxisCommand command = controlword_command(axis, word);
  std::uint16_t members = msg::HAS_DS402_CONTROLWORD | msg::HAS_POSITION_USER_TARGET_VALUE;
  command.position_user_target_value(target);
  if (options.velocity) {
    members |= msg::HAS_PROFILE_VELOCITY;
    command.profile_velocity(*options.velocity);
  }
  if (options.acceleration) {
    members |= msg::HAS_PROFILE_ACC;
    command.profile_acc(*options.acceleration);
  }
  if (options.deceleration) {
    members |= msg::HAS_PROFILE_DEC;
    command.profile_dec(*options.deceleration);
  }
  command.members(members);
  return command;
}

/// Hands the set-point over: an edge of bit 4, which may have to drop first.
Outcome say_set_point(Conversation& talk, const msg::AxisCommand& command) {
  using namespace literals;
  const auto present = talk.read(vdrive::describe("ds402_controlword"_object).address);
  if (!present) return present.outcome();
  const auto word = static_cast<std::uint16_t>(*present);
  std::vector<msg::AxisCommand> commands;
  if ((word & Controlword::kNewSetPoint) != 0) {
    commands.push_back(controlword_command(
        talk.id().axis, static_cast<std::uint16_t>(word & ~Controlword::kNewSetPoint)));
  }
  commands.push_back(command);
  return talk.say(commands);
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

Outcome Axis::enable(const CallOptions& options) {
  Conversation talk(core_, id_, options.timeout);
  if (Outcome ready = talk.take_control(); !ready) return ready;
  if (is_fault(talk.state())) return talk.not_now("enabling", "a fault reset first");
  if (talk.state() == PowerState::operation_enabled) return {};
  if (talk.state() == PowerState::quick_stop_active && options.until == Until::done) {
    if (Outcome rested = await_quick_stop(talk); !rested) return rested;
  }
  if (Outcome said = talk.say(enabling_words(talk.state())); !said) return said;
  if (talk.state() == PowerState::operation_enabled) return {};
  return talk.ended("Operation enabled");
}

Outcome Axis::disable(const CallOptions& options) {
  Conversation talk(core_, id_, options.timeout);
  if (Outcome ready = talk.take_control(); !ready) return ready;
  if (is_fault(talk.state())) return talk.not_now("disabling", "a fault reset first");
  if (talk.state() == PowerState::quick_stop_active) {
    if (Outcome rested = await_quick_stop(talk); !rested) return rested;
    if (Outcome said = talk.say({kDisableVoltage}); !said) return said;  // where 605Ah keeps it
  }
  if (Outcome said = talk.say({kShutdown}); !said) return said;
  if (options.until == Until::in_force) return {};
  Outcome seen = talk.look_until("Ready to switch on", [](const AxisSnapshot& axis) {
    return axis.state() == PowerState::ready_to_switch_on || is_fault(axis.state());
  });
  return seen && is_fault(talk.state()) ? talk.ended("Ready to switch on") : seen;
}

Outcome Axis::move_to(std::int32_t position, const MoveOptions& options) {
  return move(position, false, options);
}

Outcome Axis::move_by(std::int32_t distance, const MoveOptions& options) {
  return move(distance, true, options);
}

Outcome Axis::move(std::int32_t target, bool relative, const MoveOptions& options) {
  Conversation talk(core_, id_, options.call.timeout);
  if (Outcome ready = talk.take_control(); !ready) return ready;
  if (talk.state() != PowerState::operation_enabled) {
    return talk.not_now("a move", "Operation enabled");
  }
  if (Outcome moded = ensure_profile_position(talk); !moded) return moded;
  const msg::AxisCommand command = set_point(id_.axis, target, relative, options);
  if (Outcome said = say_set_point(talk, command); !said) return said;
  // From here on bits 12 and 10 belong to this set-point: say() returned in the tick in which it
  // acts.
  const auto acknowledged = [](const AxisSnapshot& axis) {
    return axis.shows(Statusword::kSetPointAcknowledge);
  };
  if (Outcome taken = talk.look_enabled_until("the acknowledge, bit 12", acknowledged); !taken) {
    return taken;
  }
  if (options.call.until == Until::done) {
    if (Outcome reached = talk.look_enabled_until("target reached, bit 10", target_reached);
        !reached) {
      return reached;
    }
  }
  return talk.say({kEnableOperation});
}

Outcome Axis::halt(const CallOptions& options) {
  Conversation talk(core_, id_, options.timeout);
  if (Outcome ready = talk.take_control(); !ready) return ready;
  if (talk.state() != PowerState::operation_enabled) {
    return talk.not_now("a halt", "Operation enabled");
  }
  if (Outcome said = talk.say({kHalt}); !said) return said;
  if (options.until == Until::in_force) return {};
  return talk.look_enabled_until("standstill, bit 10", target_reached);
}

Outcome Axis::resume(const CallOptions& options) {
  Conversation talk(core_, id_, options.timeout);
  if (Outcome ready = talk.take_control(); !ready) return ready;
  if (talk.state() != PowerState::operation_enabled) {
    return talk.not_now("resuming", "Operation enabled");
  }
  if (Outcome said = talk.say({kEnableOperation}); !said) return said;
  if (options.until == Until::in_force) return {};
  return talk.look_enabled_until("target reached, bit 10", target_reached);
}

Outcome Axis::quick_stop(const CallOptions& options) {
  Conversation talk(core_, id_, options.timeout);
  if (Outcome ready = talk.take_control(); !ready) return ready;
  if (is_fault(talk.state())) return talk.not_now("a quick stop", "a fault reset first");
  if (Outcome said = talk.say({kQuickStop}); !said) return said;
  if (options.until == Until::in_force) return {};
  if (Outcome rested = await_quick_stop(talk); !rested) return rested;
  return is_fault(talk.state()) ? talk.ended("the quick stop to end") : Outcome();
}

Outcome Axis::reset_fault(const CallOptions& options) {
  Conversation talk(core_, id_, options.timeout);
  if (Outcome ready = talk.take_control(); !ready) return ready;
  if (!is_fault(talk.state())) return {};
  Outcome reacted = talk.look_until("the fault reaction to end", [](const AxisSnapshot& axis) {
    return axis.state() != PowerState::fault_reaction_active;
  });
  if (!reacted) return reacted;
  if (Outcome said = talk.say(reset_words()); !said) return said;
  if (!is_fault(talk.state())) return {};
  return Outcome::refused(wire_code(AbortCode::refused_in_present_device_state),
                          talk.ended("the end of the fault").message() + ", the cause persists");
}

Outcome Axis::power_cycle(const CallOptions& options) {
  Conversation talk(core_, id_, options.timeout);
  if (Outcome ready = talk.listen(); !ready) return ready;
  msg::Request request;
  request.kind(msg::REQUEST_POWER_CYCLE);
  request.axes().push_back(id_.axis);
  const auto reply = core_->control.exchange(talk.target(), std::move(request),
                                             "power cycle of axis " + to_string(id_));
  if (!reply) return reply.outcome();
  if (options.until == Until::in_force) return {};
  if (Outcome seen = talk.look_at(std::max(reply->tick(), talk.now().tick + 1), "the power-up");
      !seen) {
    return seen;
  }
  Outcome seen = talk.look_until("Switch on disabled", [](const AxisSnapshot& axis) {
    return axis.state() == PowerState::switch_on_disabled || is_fault(axis.state());
  });
  return seen && is_fault(talk.state()) ? talk.ended("Switch on disabled") : seen;
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
  return core_->requests.exchange(*target, std::move(request), what).outcome();
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

Result<AxisSnapshot> Axis::wait_until(const std::function<bool(const AxisSnapshot&)>& condition,
                                      std::chrono::nanoseconds timeout) const {
  Conversation talk(core_, id_, timeout);
  if (Outcome ready = talk.listen(); !ready) return ready;
  if (Outcome seen = talk.look_until("the condition", condition); !seen) return seen;
  return talk.now();
}

}  // namespace vdrive::client
