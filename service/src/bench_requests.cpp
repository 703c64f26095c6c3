// SPDX-License-Identifier: Apache-2.0
// Requests: reads, writes, control of axes, steps.
#include "bench_engine.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdrive::service {
namespace {

constexpr std::uint32_t kLocalControl = wire_code(AbortCode::refused_local_control);

msg::ObjectResult& add_result(const msg::ObjectAccess& object, std::uint32_t code,
                              msg::Reply& reply) {
  auto& result = reply.objects().emplace_back();
  result.axis(object.axis());
  result.index(object.index());
  result.subindex(object.subindex());
  result.abort_code(code);
  result.value(object.value());
  return result;
}

/// @return the reason of a request whose results are complete.
std::uint32_t reason_of(const msg::Reply& reply) {
  const auto& results = reply.objects();
  if (results.empty()) return msg::REASON_NOTHING_DONE;
  const bool unknown_axis = std::ranges::any_of(results, [](const auto& result) {
    return result.abort_code() == msg::REASON_UNKNOWN_AXIS;
  });
  return unknown_axis ? msg::REASON_UNKNOWN_AXIS : msg::REASON_NONE;
}

}  // namespace

void BenchEngine::handle_request(const Arrival& arrival) {
  OutgoingReply* const outgoing = outbox_.replies.free_slot();
  if (outgoing == nullptr) {
    counters_.queue_overflows.add();
    return;  // nothing is done that could not be answered
  }
  if (is_repeat(arrival)) return;
  begin_reply(arrival, *outgoing);
  std::uint32_t reason = check_request(arrival);
  ordered_ = 0;
  if (reason == msg::REASON_NONE) reason = carry_out(arrival.request, outgoing->reply);
  if (ordered_ > 0) {
    wait_for_orders(arrival.request.session(), reason, *outgoing);
    return;
  }
  finish_reply(arrival.request.session(), reason, outgoing->reply);
  outbox_.replies.push();
}

bool BenchEngine::is_repeat(const Arrival& arrival) {
  const auto& request = arrival.request;
  if (request.client() == 0 || !is_of_this_run(request)) {
    return false;  // nothing is ever done
  }
  const Fate fate = requests_.fate_of(request.client(), request.request_id());
  if (fate == Fate::unknown) {
    requests_.take(request.client(), request.request_id());
    return false;
  }
  if (arrival.refusal == msg::REASON_NONE) hear(request.session());
  const bool is_in_progress =
      fate == Fate::taken || (fate == Fate::forgotten && is_storing(request));
  if (!is_in_progress) answer_again(arrival);
  return true;
}

/// With the answer of then, but for the statuses of a step, which are of now; where it is not kept
/// any more with a refusal, for doing it again would be worse.
void BenchEngine::answer_again(const Arrival& arrival) {
  OutgoingReply* const outgoing = outbox_.replies.free_slot();
  if (outgoing == nullptr) {
    counters_.queue_overflows.add();
    return;
  }
  const auto& request = arrival.request;
  begin_reply(arrival, *outgoing);
  auto& reply = outgoing->reply;
  const Fate fate = requests_.fate_of(request.client(), request.request_id());
  if (fate == Fate::answered) {
    reply = *requests_.answer_to(request.client(), request.request_id());
    const bool shows =
        reply.reason() == msg::REASON_NONE || reply.reason() == msg::REASON_MISSING_STEPPER;
    if (request.kind() == msg::REQUEST_STEP && shows && knows_axes(request)) {
      add_statuses(request, reply);
    }
  } else {
    finish_reply(request.session(), msg::REASON_TOO_LATE, reply);
  }
  outbox_.replies.push();
}

bool BenchEngine::is_of_this_run(const msg::Request& request) const noexcept {
  return request.incarnation() == 0 || request.incarnation() == identity_.incarnation;
}

void BenchEngine::begin_reply(const Arrival& arrival, OutgoingReply& outgoing) const {
  outgoing.destination = arrival.source;
  auto& reply = outgoing.reply;
  reply.client(arrival.request.client());
  reply.request_id(arrival.request.request_id());
  reply.bench(identity_.bench);
  reply.incarnation(identity_.incarnation);
  reply.refused_axis(0);
  reply.owner_session(0);
  reply.snapshot(0);
  reply.missing_stepper(0);
  reply.tick(tick_);
  reply.objects().clear();
  reply.statuses().clear();
}

void BenchEngine::finish_reply(std::uint64_t session, std::uint32_t reason, msg::Reply& reply) {
  reply.reason(reason);
  const SessionRecord* const record = session == 0 ? nullptr : control_.find(session);
  reply.epoch(record == nullptr ? 0 : record->epoch);
  reply.last_sequence(record == nullptr ? 0 : record->last_sequence);
  counters_.requests_answered.add();
  std::uint16_t axis = reply.refused_axis();
  for (const auto& object : reply.objects()) {
    if (reason == msg::REASON_NONE && object.abort_code() != 0) {
      reason = object.abort_code();
      axis = object.axis();
    }
  }
  if (reason != msg::REASON_NONE) {
    counters_.refusals.add(reason);
    report({.kind = msg::EVENT_REFUSED,
            .axis = axis,
            .session = session,
            .code = reason,
            .detail = RefusedMessage{.number = reply.request_id()}});
  }
  if (reply.reason() != msg::REASON_WRONG_INCARNATION) keep(reply);
}

/// Without statuses, of which there may be very many.
void BenchEngine::keep(msg::Reply& reply) {
  if (auto* const kept = requests_.keep(reply.client(), reply.request_id())) {
    std::swap(reply.statuses(), statuses_);
    *kept = reply;
    std::swap(reply.statuses(), statuses_);
  }
}

std::uint32_t BenchEngine::check_request(const Arrival& arrival) const {
  const auto& request = arrival.request;
  if (request.client() == 0) return msg::REASON_BAD_SESSION;
  if (!is_of_this_run(request)) return msg::REASON_WRONG_INCARNATION;
  if (braking_ && request.kind() != msg::REQUEST_READ) return msg::REASON_SHUTTING_DOWN;
  return arrival.refusal;
}

std::uint32_t BenchEngine::carry_out(const msg::Request& request, msg::Reply& reply) {
  hear(request.session());
  switch (request.kind()) {
    case msg::REQUEST_READ:
      return read_objects(request, reply);
    case msg::REQUEST_WRITE:
      return write_objects(request, reply);
    case msg::REQUEST_ACQUIRE:
      return acquire(request, false, reply);
    case msg::REQUEST_TAKE_OVER:
      return acquire(request, true, reply);
    case msg::REQUEST_RELEASE:
      return release(request, reply);
    case msg::REQUEST_POWER_CYCLE:
      return power_cycle(request, reply);
    case msg::REQUEST_STORE:
    case msg::REQUEST_RESTORE:
      return store_axes(request, reply);
    case msg::REQUEST_TAKE_SNAPSHOT:
      return take_snapshot(request, reply);
    case msg::REQUEST_RESTORE_SNAPSHOT:
      return restore_snapshot(request, reply);
    case msg::REQUEST_DROP_SNAPSHOT:
      return drop_snapshot(request);
    case msg::REQUEST_SET_RATE:
      return set_rate(request);
    case msg::REQUEST_STEP:
    case msg::REQUEST_JOIN_CLOCK:
    case msg::REQUEST_LEAVE_CLOCK:
      return msg::REASON_WRONG_CLOCK_MODE;
    default:
      return msg::REASON_UNKNOWN_KIND;
  }
}

std::uint32_t BenchEngine::read_objects(const msg::Request& request, msg::Reply& reply) {
  for (const auto& object : request.objects()) {
    const auto axis = index_of(object.axis());
    if (!axis) {
      add_result(object, msg::REASON_UNKNOWN_AXIS, reply).value(0);
      refuse_axis(object.axis(), reply);
      continue;
    }
    const ReadResult result = bank_.read(*axis, {object.index(), object.subindex()});
    add_result(object, wire_code(result.code), reply).value(result.value);
  }
  return reason_of(reply);
}

std::uint32_t BenchEngine::write_objects(const msg::Request& request, msg::Reply& reply) {
  for (const auto& object : request.objects()) {
    const std::uint32_t code = write_object(object, request.session(), reply.objects().size());
    add_result(object, code, reply);
    if (code == msg::REASON_UNKNOWN_AXIS || code == kLocalControl) {
      refuse_axis(object.axis(), reply);
    }
  }
  reply.tick(tick_ + 1);
  return reason_of(reply);
}

std::uint32_t BenchEngine::write_object(const msg::ObjectAccess& object, std::uint64_t session,
                                        std::size_t place) {
  const auto axis = index_of(object.axis());
  if (!axis) return msg::REASON_UNKNOWN_AXIS;
  const ObjectAddress address{object.index(), object.subindex()};
  const std::uint64_t owner = control_.owner(*axis).session;
  if (owner != 0 && owner != session && !has_role(address, Role::test_input)) return kLocalControl;
  if (owner == 0 && has_role(address, Role::command)) {
    return write_command_object(*axis, address, object.value(), session);
  }
  if (address == kStoreParameters || address == kRestoreParameters) {
    return store_by_write(*axis, address, object.value(), place);
  }
  return wire_code(write(*axis, address, object.value()));
}

std::uint32_t BenchEngine::write_command_object(std::size_t axis, ObjectAddress address,
                                                std::int64_t value, std::uint64_t session) {
  SessionRecord* const record = session == 0 ? nullptr : control_.find_or_add(session, tick_);
  if (record == nullptr) return kLocalControl;
  if (record->must_acquire) {  // it may have been on its way since before the loss
    return msg::REASON_STALE_EPOCH;
  }
  const AbortCode code = write(axis, address, value);
  if (code == AbortCode::none) {
    control_.give(axis, *record);
    control_.renew_epoch(*record);
    record->last_heard_tick = tick_;
    report({.kind = msg::EVENT_CONTROL_CHANGED,
            .axis = numbers_[axis],
            .session = session,
            .code = record->epoch,
            .detail = Count{1}});
  }
  return wire_code(code);
}

std::uint32_t BenchEngine::acquire(const msg::Request& request, bool by_force, msg::Reply& reply) {
  if (request.session() == 0) return msg::REASON_BAD_SESSION;
  if (const auto reason = check_axes(request, by_force, reply); reason != msg::REASON_NONE) {
    return reason;
  }
  SessionRecord* const record = control_.find_or_add(request.session(), tick_);
  if (record == nullptr) return msg::REASON_QUEUE_FULL;
  std::size_t gained = 0;
  for (const std::uint16_t number : request.axes()) {
    const std::size_t axis = *index_of(number);
    if (control_.owner(axis).session != request.session()) {
      lose_axis(axis);
      control_.give(axis, *record);
      ++gained;
    }
  }
  record->last_heard_tick = tick_;
  record->must_acquire = false;
  if (gained > 0) {
    control_.renew_epoch(*record);
    report({.kind = msg::EVENT_CONTROL_CHANGED,
            .axis = gained == 1 ? request.axes().front() : std::uint16_t{0},
            .session = request.session(),
            .code = record->epoch,
            .detail = Count{gained}});
  }
  return msg::REASON_NONE;
}

/// The owner of the axis, if any, loses it to somebody else: its epoch and its waiting frames end.
void BenchEngine::lose_axis(std::size_t axis) {
  SessionRecord* const loser = control_.find(control_.owner(axis).session);
  if (loser == nullptr || control_.owner(axis).session == 0) return;
  control_.take(axis);
  control_.renew_epoch(*loser);
  loser->must_acquire = true;
  drop_pending_of_session(loser->session);
  report({.kind = msg::EVENT_CONTROL_CHANGED, .axis = numbers_[axis], .session = loser->session});
}

std::uint32_t BenchEngine::release(const msg::Request& request, msg::Reply& reply) {
  if (request.session() == 0) return msg::REASON_BAD_SESSION;
  SessionRecord* const record = control_.find(request.session());
  if (record == nullptr || record->owned_axes == 0) return msg::REASON_NOTHING_DONE;
  for (const std::uint16_t number : request.axes()) {
    const auto axis = index_of(number);
    if (!axis || control_.owner(*axis).session != request.session()) {
      refuse_axis(number, reply);
      return axis ? msg::REASON_NOT_OWNER : msg::REASON_UNKNOWN_AXIS;
    }
  }
  const std::size_t before = record->owned_axes;
  free_axes(request);
  control_.renew_epoch(*record);
  drop_pending_of_session(request.session());
  report({.kind = msg::EVENT_CONTROL_CHANGED,
          .axis = request.axes().size() == 1 ? request.axes().front() : std::uint16_t{0},
          .session = request.session(),
          .detail = Count{before - record->owned_axes}});
  return msg::REASON_NONE;
}

/// Frees the axes that the request names, or all of its session when it names none.
void BenchEngine::free_axes(const msg::Request& request) {
  for (const std::uint16_t number : request.axes()) control_.take(*index_of(number));
  for (std::size_t axis = 0; request.axes().empty() && axis < numbers_.size(); ++axis) {
    if (control_.owner(axis).session == request.session()) control_.take(axis);
  }
}

std::uint32_t BenchEngine::power_cycle(const msg::Request& request, msg::Reply& reply) {
  if (const auto reason = check_axes(request, false, reply); reason != msg::REASON_NONE) {
    return reason;
  }
  for (const std::uint16_t number : request.axes()) {
    const std::size_t axis = *index_of(number);
    drop_pending_of_axis(number);
    bank_.power_cycle(axis);
    to_journal(
        {.kind = JournalChange::Kind::power_cycle, .axis = static_cast<std::uint16_t>(axis)});
    mark_changed(axis);
  }
  reply.tick(tick_ + 1);
  return msg::REASON_NONE;
}

/// Whose bench it is does not matter: time belongs to all.
std::uint32_t BenchEngine::set_rate(const msg::Request& request) {
  if (clock_ != ClockMode::realtime) return msg::REASON_WRONG_CLOCK_MODE;
  const double rate = request.rate();
  if (!(rate == 0.0 || (rate >= kLowestRate && rate <= kHighestRate))) {  // NaN too
    return msg::REASON_OUT_OF_RANGE;
  }
  if (rate == rate_) return msg::REASON_NONE;
  rate_ = std::abs(rate);  // no negative zero
  counters_.rate.store(rate_, std::memory_order_relaxed);
  stretch_watchdog();
  for (auto& record : control_.sessions()) {  // the time that masters have begins anew
    record.last_heard_tick = tick_;
  }
  report({.kind = msg::EVENT_CLOCK_CHANGED,
          .session = request.session(),
          .code = msg::REQUEST_SET_RATE,
          .detail = NewRate{rate_}});
  return msg::REASON_NONE;
}

std::uint32_t BenchEngine::check_axes(const msg::Request& request, bool owned_by_others_allowed,
                                      msg::Reply& reply) const {
  if (request.axes().empty()) return msg::REASON_NOTHING_DONE;
  for (const std::uint16_t number : request.axes()) {
    const auto axis = index_of(number);
    if (!axis) {
      refuse_axis(number, reply);
      return msg::REASON_UNKNOWN_AXIS;
    }
    const std::uint64_t owner = control_.owner(*axis).session;
    if (!owned_by_others_allowed && owner != 0 && owner != request.session()) {
      refuse_axis(number, reply);
      return kLocalControl;
    }
  }
  return msg::REASON_NONE;
}

/// Names the first axis that the refusal speaks of, and its owner.
void BenchEngine::refuse_axis(std::uint16_t number, msg::Reply& reply) const {
  if (reply.refused_axis() != 0) return;
  reply.refused_axis(number);
  if (const auto axis = index_of(number)) reply.owner_session(control_.owner(*axis).session);
}

std::uint32_t BenchEngine::check_step(const Arrival& arrival) const {
  const auto& request = arrival.request;
  if (const auto reason = check_request(arrival); reason != msg::REASON_NONE) return reason;
  if (clock_ != ClockMode::lockstep) return msg::REASON_WRONG_CLOCK_MODE;
  if (request.ticks() > kMaxTicksPerStep) return msg::REASON_TOO_MANY_TICKS;
  if (request.session() == 0 && request.last_sequence() != 0) return msg::REASON_BAD_SESSION;
  return knows_axes(request) ? msg::REASON_NONE : msg::REASON_UNKNOWN_AXIS;
}

bool BenchEngine::knows_axes(const msg::Request& request) const {
  return std::ranges::all_of(request.axes(), [&](std::uint16_t number) {
    return index_of(number).has_value();
  });
}

bool BenchEngine::has_arrived(std::uint64_t session, std::uint64_t sequence) {
  if (sequence == 0) return true;
  const SessionRecord* const record = control_.find(session);
  return record != nullptr && record->last_sequence >= sequence;
}

void BenchEngine::hear(std::uint64_t session) {
  if (session == 0) return;
  if (SessionRecord* const record = control_.find(session); record != nullptr) {
    record->last_heard_tick = tick_;
  }
}

void BenchEngine::answer_step(const Arrival& arrival, std::uint32_t reason,
                              std::uint64_t missing_stepper) {
  OutgoingReply* const outgoing = outbox_.replies.free_slot();
  if (outgoing == nullptr) {
    counters_.queue_overflows.add();
    return;
  }
  begin_reply(arrival, *outgoing);
  auto& reply = outgoing->reply;
  reply.missing_stepper(missing_stepper);
  if (reason == msg::REASON_NONE || reason == msg::REASON_MISSING_STEPPER) {
    add_statuses(arrival.request, reply);
  } else if (reason == msg::REASON_UNKNOWN_AXIS) {
    const auto& axes = arrival.request.axes();
    const auto unknown = std::ranges::find_if(axes, [&](std::uint16_t number) {
      return !index_of(number);
    });
    refuse_axis(*unknown, reply);
  }
  finish_reply(arrival.request.session(), reason, reply);
  outbox_.replies.push();
}

void BenchEngine::add_statuses(const msg::Request& request, msg::Reply& reply) const {
  reply.statuses().resize(request.axes().size());
  for (std::size_t position = 0; position < request.axes().size(); ++position) {
    const std::uint16_t number = request.axes()[position];
    const std::size_t axis = *index_of(number);
    wire::to_message(bank_.status(axis), {identity_.bench, number}, tick_, control_.owner(axis),
                     reply.statuses()[position]);
  }
}

}  // namespace vdrive::service
