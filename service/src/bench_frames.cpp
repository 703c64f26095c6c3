// SPDX-License-Identifier: Apache-2.0
// Command frames: validation, waiting for their tick, application.
#include "bench_engine.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;

constexpr ObjectAddress kControlword = describe("ds402_controlword"_object).address;

constexpr std::uint32_t kKnownFlags =
    msg::FRAME_ALL_OR_NOTHING | msg::FRAME_CANCEL_PENDING | msg::FRAME_WANT_REPLY;

/// A register member of AxisCommand. Rows in the order of their bits: the order of application.
struct RegisterMember {
  std::uint16_t bit = 0;
  ObjectAddress address;
  std::int64_t (*value)(const msg::AxisCommand& command) = nullptr;
};

constexpr std::array<RegisterMember, 6> kRegisterMembers{{
    {msg::HAS_OP_MODE_CMD, describe("op_mode_cmd"_object).address,
     [](const auto& c) -> std::int64_t {
       return c.op_mode_cmd();
     }},
    {msg::HAS_POSITION_USER_TARGET_VALUE, describe("position_user_target_value"_object).address,
     [](const auto& c) -> std::int64_t {
       return c.position_user_target_value();
     }},
    {msg::HAS_PROFILE_VELOCITY, describe("profile_velocity"_object).address,
     [](const auto& c) -> std::int64_t {
       return c.profile_velocity();
     }},
    {msg::HAS_PROFILE_ACC, describe("profile_acc"_object).address,
     [](const auto& c) -> std::int64_t {
       return c.profile_acc();
     }},
    {msg::HAS_PROFILE_DEC, describe("profile_dec"_object).address,
     [](const auto& c) -> std::int64_t {
       return c.profile_dec();
     }},
    {msg::HAS_POSITIONING_OPTION_CODE, describe("positioning_option_code"_object).address,
     [](const auto& c) -> std::int64_t {
       return c.positioning_option_code();
     }},
}};

constexpr std::uint16_t kKnownMembers = [] {
  std::uint16_t members = msg::HAS_DS402_CONTROLWORD;
  for (const auto& member : kRegisterMembers) {
    members = static_cast<std::uint16_t>(members | member.bit);
  }
  return members;
}();

}  // namespace

void BenchEngine::handle_frame(Arrival& arrival) {
  auto& frame = arrival.frame;
  counters_.frames_received.add();
  if (const std::uint32_t reason = check_sender(frame); reason != msg::REASON_NONE) {
    refuse_frame(frame, reason);
    return;
  }
  SessionRecord& record = *control_.find(frame.session());
  record.last_heard_tick = tick_;
  if (is_repeat(frame)) return;
  if (const std::uint32_t reason = check_frame(arrival, record); reason != msg::REASON_NONE) {
    refuse_frame(frame, reason);
    return;
  }
  const bool cancels = (frame.flags() & msg::FRAME_CANCEL_PENDING) != 0;
  if (cancels || !frame.axes().empty()) record.last_command = frame.sequence_number();
  if (cancels) drop_pending_of_session(frame.session());
  if (frame.apply_at_tick() <= tick_ + 1) {
    apply_frame(frame);
  } else if (!pending_.insert(frame.apply_at_tick(), frame)) {
    refuse_frame(frame, msg::REASON_QUEUE_FULL);
  }
  counters_.pending_frames.set(pending_.size());
}

/// What is refused here is no frame of a session of this run: it is not remembered.
std::uint32_t BenchEngine::check_sender(const msg::CommandFrame& frame) {
  if (frame.incarnation() != identity_.incarnation) return msg::REASON_WRONG_INCARNATION;
  if (frame.session() == 0) return msg::REASON_BAD_SESSION;
  return control_.find_or_add(frame.session(), tick_) == nullptr ? msg::REASON_QUEUE_FULL
                                                                 : msg::REASON_NONE;
}

/// A client repeats what was not answered after the way between it and this bench broke.
bool BenchEngine::is_repeat(const msg::CommandFrame& frame) {
  const std::uint64_t session = frame.session();
  const std::uint64_t sequence = frame.sequence_number();
  switch (commands_.fate_of(session, sequence)) {
    case Fate::unknown:
      commands_.take(session, sequence);
      return false;
    case Fate::taken:  // it waits for its tick, or nobody wanted an answer
      break;
    case Fate::answered:
      post(*commands_.answer_to(session, sequence));
      break;
    case Fate::forgotten:
      if (!pending_.contains(session, sequence)) refuse_frame(frame, msg::REASON_TOO_LATE);
      break;
  }
  return true;
}

std::uint32_t BenchEngine::check_frame(const Arrival& arrival, SessionRecord& record) {
  const auto& frame = arrival.frame;
  record.last_sequence = std::max(record.last_sequence, frame.sequence_number());
  // Commands keep their order; one that was overtaken by keep-alives alone still acts.
  if (frame.sequence_number() <= record.last_command) return msg::REASON_TOO_LATE;
  if (record.epoch == 0 && frame.epoch() == 0) return msg::REASON_NOT_OWNER;
  if (frame.epoch() != record.epoch) return msg::REASON_STALE_EPOCH;
  if ((frame.flags() & ~kKnownFlags) != 0) return msg::REASON_UNKNOWN_FLAGS;
  if (braking_ && !frame.axes().empty()) return msg::REASON_SHUTTING_DOWN;
  return arrival.refusal != msg::REASON_NONE ? arrival.refusal : check_time(frame);
}

std::uint32_t BenchEngine::check_time(const msg::CommandFrame& frame) const {
  const std::uint64_t apply_at = frame.apply_at_tick() == 0 ? tick_ + 1 : frame.apply_at_tick();
  if (apply_at <= tick_) return msg::REASON_TOO_LATE;
  if (apply_at - tick_ > furthest_ahead_) return msg::REASON_TOO_FAR_AHEAD;
  const bool expires_before = frame.valid_until_tick() != 0 && frame.valid_until_tick() < apply_at;
  return expires_before ? msg::REASON_TOO_LATE : msg::REASON_NONE;
}

void BenchEngine::apply_due_frames() {
  while (pending_.take_due(tick_ + 1, due_frame_)) {
    // After a jump of the tick number a frame may be past its time.
    if (due_frame_.valid_until_tick() != 0 && due_frame_.valid_until_tick() < tick_ + 1) {
      refuse_frame(due_frame_, msg::REASON_TOO_LATE);
    } else {
      apply_frame(due_frame_);
    }
  }
}

void BenchEngine::apply_frame(const msg::CommandFrame& frame) {
  command_reply_.refusals().clear();
  command_reply_.ignored_set_points().clear();
  ++frame_count_;
  const auto& commands = frame.axes();
  for (std::size_t position = 0; position < commands.size(); ++position) {
    const std::uint32_t reason = check_command(commands[position], frame.session());
    skipped_[position] = reason != msg::REASON_NONE;
    if (skipped_[position]) refuse(commands[position].axis(), {}, reason);
  }
  if ((frame.flags() & msg::FRAME_ALL_OR_NOTHING) == 0) {
    apply_each(frame);
  } else if (command_reply_.refusals().empty()) {
    apply_all_or_nothing(frame);
  }
  if (!command_reply_.refusals().empty()) {
    counters_.frames_refused.add();
    const auto& first = command_reply_.refusals().front();
    report({.kind = msg::EVENT_REFUSED,
            .axis = first.axis(),
            .session = frame.session(),
            .code = first.reason(),
            .detail = RefusedMessage{.number = frame.sequence_number()}});
  }
  const bool has_news =
      !command_reply_.refusals().empty() || !command_reply_.ignored_set_points().empty();
  if (has_news || (frame.flags() & msg::FRAME_WANT_REPLY) != 0) send_reply(frame, command_reply_);
}

std::uint32_t BenchEngine::check_command(const msg::AxisCommand& command, std::uint64_t session) {
  const auto axis = index_of(command.axis());
  if (!axis) return msg::REASON_UNKNOWN_AXIS;
  if (named_in_[*axis] == frame_count_) return msg::REASON_AXIS_TWICE;
  named_in_[*axis] = frame_count_;
  if (control_.owner(*axis).session != session) return msg::REASON_NOT_OWNER;
  return (command.members() & ~kKnownMembers) != 0 ? msg::REASON_UNKNOWN_MEMBERS : msg::REASON_NONE;
}

void BenchEngine::apply_each(const msg::CommandFrame& frame) {
  const auto& commands = frame.axes();
  for (std::size_t position = 0; position < commands.size(); ++position) {
    if (skipped_[position]) {
      counters_.commands_refused.add();
      continue;
    }
    const bool whole = apply_registers(commands[position], false);
    apply_controlword(commands[position], frame.sequence_number());
    (whole ? counters_.commands_applied : counters_.commands_refused).add();
  }
}

/// Registers of all axes first: a controlword acts at once, a register can be put back.
void BenchEngine::apply_all_or_nothing(const msg::CommandFrame& frame) {
  undo_.clear();
  bool accepted = true;
  for (const auto& command : frame.axes()) accepted = apply_registers(command, true) && accepted;
  if (!accepted) {
    for (; !undo_.empty(); undo_.pop_back()) {  // the latest first
      const Undo& undo = undo_.back();
      if (bank_.write(undo.axis, undo.address, undo.value) == AbortCode::none) {
        to_journal({.axis = undo.axis, .address = undo.address, .value = undo.value});
      }
    }
    counters_.commands_refused.add(frame.axes().size());
    return;
  }
  for (const auto& command : frame.axes()) apply_controlword(command, frame.sequence_number());
  counters_.commands_applied.add(frame.axes().size());
}

bool BenchEngine::apply_registers(const msg::AxisCommand& command, bool undoable) {
  bool accepted = true;
  for (const auto& member : kRegisterMembers) {
    if ((command.members() & member.bit) != 0) {
      accepted = apply_register(command.axis(), member.address, member.value(command), undoable) &&
                 accepted;
    }
  }
  for (const auto& object : command.objects()) {
    accepted = apply_register(command.axis(), {object.index(), object.subindex()}, object.value(),
                              undoable) &&
               accepted;
  }
  return accepted;
}

bool BenchEngine::apply_register(std::uint16_t number, ObjectAddress address, std::int64_t value,
                                 bool undoable) {
  const std::size_t axis = *index_of(number);
  // The controlword has a member, whose place is last. Storing is answered when it is durable, and
  // frames are answered at once.
  if (address == kControlword || address == kStoreParameters || address == kRestoreParameters) {
    refuse(number, address, wire_code(AbortCode::cannot_be_mapped_to_pdo));
    return false;
  }
  const ReadResult before = undoable ? bank_.read(axis, address) : ReadResult{};
  const AbortCode code = write(axis, address, value);
  if (code != AbortCode::none) {
    refuse(number, address, wire_code(code));
    return false;
  }
  if (undoable && before.code == AbortCode::none && undo_.size() < undo_.capacity()) {
    undo_.push_back({static_cast<std::uint16_t>(axis), address, before.value});
  }
  return true;
}

void BenchEngine::apply_controlword(const msg::AxisCommand& command, std::uint64_t sequence) {
  const std::size_t axis = *index_of(command.axis());
  if ((command.members() & msg::HAS_DS402_CONTROLWORD) != 0) {
    const std::uint32_t ignored = bank_.ignored_set_points(axis);
    const AbortCode code = write(axis, kControlword, command.ds402_controlword());
    if (code != AbortCode::none) {
      refuse(command.axis(), kControlword, wire_code(code));
    } else if (bank_.ignored_set_points(axis) != ignored) {
      command_reply_.ignored_set_points().push_back(command.axis());
    }
  }
  control_.set_applied(axis, sequence);
}

void BenchEngine::refuse(std::uint16_t axis, ObjectAddress address, std::uint32_t reason) {
  counters_.refusals.add(reason);
  auto& refusals = command_reply_.refusals();
  if (refusals.size() < msg::MAX_AXES_PER_FRAME) {
    auto& refusal = refusals.emplace_back();
    refusal.axis(axis);
    refusal.index(address.index);
    refusal.subindex(address.subindex);
    refusal.reason(reason);
  }
}

/// In a reply of its own: a frame that halts drops others while its answer is being built.
void BenchEngine::refuse_frame(const msg::CommandFrame& frame, std::uint32_t reason) {
  frame_refusal_.refusals().front().reason(reason);
  counters_.frames_refused.add();
  report(
      {.kind = msg::EVENT_REFUSED,
       .session = frame.session(),
       .code = reason,
       .detail = RefusedMessage{.number = frame.sequence_number(),
                                .late_by = reason == msg::REASON_TOO_LATE ? lateness(frame) : 0}});
  send_reply(frame, frame_refusal_);
}

/// @return how many ticks the next one is past the one that the frame was meant for.
std::uint64_t BenchEngine::lateness(const msg::CommandFrame& frame) const noexcept {
  const std::uint64_t next = tick_ + 1;
  const auto past = [next](std::uint64_t tick) {
    return tick != 0 && tick < next ? next - tick : 0;
  };
  return std::max(past(frame.apply_at_tick()), past(frame.valid_until_tick()));
}

void BenchEngine::send_reply(const msg::CommandFrame& frame, msg::CommandReply& reply) {
  reply.bench(identity_.bench);
  reply.incarnation(identity_.incarnation);
  reply.session(frame.session());
  reply.sequence_number(frame.sequence_number());
  reply.tick(tick_ + 1);
  if (frame.incarnation() == identity_.incarnation) {
    if (auto* const kept = commands_.keep(frame.session(), frame.sequence_number())) *kept = reply;
  }
  post(reply);
}

void BenchEngine::post(const msg::CommandReply& reply) {
  msg::CommandReply* const slot = outbox_.command_replies.free_slot();
  if (slot == nullptr) {
    counters_.queue_overflows.add();
    return;
  }
  *slot = reply;
  outbox_.command_replies.push();
}

void BenchEngine::drop_pending_of_session(std::uint64_t session) {
  pending_.drop_if(
      [&](const auto& frame) {
        return frame.session() == session;
      },
      [&](const auto& frame) {
        refuse_frame(frame, msg::REASON_CANCELLED);
      });
}

void BenchEngine::drop_pending_of_axis(std::uint16_t axis) {
  pending_.drop_if(
      [&](const auto& frame) {
        return std::ranges::any_of(frame.axes(), [&](const auto& command) {
          return command.axis() == axis;
        });
      },
      [&](const auto& frame) {
        refuse_frame(frame, msg::REASON_CANCELLED);
      });
}

}  // namespace vdrive::service
