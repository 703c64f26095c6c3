// SPDX-License-Identifier: Apache-2.0
#include "engine/request_answers.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::service {

RequestAnswers::RequestAnswers(const BenchIdentity& identity, const BenchClock& clock,
                               const BenchAxes& axes, const Masters& masters, BenchEvents& events,
                               Ring<OutgoingReply>& queue, Counters& counters)
    : identity_(identity),
      clock_(clock),
      axes_(axes),
      masters_(masters),
      events_(events),
      queue_(queue),
      counters_(counters) {}

bool RequestAnswers::is_of_this_run(const msg::Request& request) const noexcept {
  return request.incarnation == 0 || request.incarnation == identity_.incarnation;
}

std::optional<std::uint16_t> RequestAnswers::unknown_axis(const msg::Request& request) const {
  const auto unknown = std::ranges::find_if(request.axes, [&](std::uint16_t number) {
    return !axes_.index_of(number);
  });
  return unknown == request.axes.end() ? std::nullopt : std::optional(*unknown);
}

OutgoingReply* RequestAnswers::open() {
  OutgoingReply* const outgoing = queue_.free_slot();
  if (outgoing == nullptr) counters_.queue_overflows.add();
  return outgoing;
}

void RequestAnswers::begin(const Arrival& arrival, OutgoingReply& outgoing) const {
  outgoing.destination = arrival.source;
  auto& reply = outgoing.reply;
  reply.client = arrival.request.client;
  reply.request_id = arrival.request.request_id;
  reply.bench = identity_.bench;
  reply.incarnation = identity_.incarnation;
  reply.refused_axis = 0;
  reply.owner_session = 0;
  reply.snapshot = 0;
  reply.missing_stepper = 0;
  reply.tick = clock_.tick();
  reply.objects.clear();
  outgoing.axes.clear();
  outgoing.page.reset();
}

/// Reading an entry of 1003h beyond the last fault does not count as a refusal: programs that read
/// all objects find the end of the list that way.
void RequestAnswers::finish(std::uint64_t session, Reason reason, msg::Reply& reply,
                            Objects objects) {
  reply.reason = reason.on_wire();
  const SessionRecord* const record = session == 0 ? nullptr : masters_.find(session);
  reply.epoch = record == nullptr ? 0 : record->epoch;
  reply.last_sequence = record == nullptr ? 0 : record->last_sequence;
  counters_.requests_answered.add();
  std::uint16_t axis = reply.refused_axis;
  msg::Reason code = reason.on_wire();  // of the request, or of its first refused object
  for (const auto& object : reply.objects) {
    if (objects == Objects::history) break;
    if (object.abort_code == Reason(AbortCode::no_data_available).on_wire()) continue;
    if (code == msg::Reason::none && object.abort_code != msg::Reason::none) {
      code = object.abort_code;
      axis = object.axis;
    }
  }
  if (code != msg::Reason::none) {
    counters_.refusals.add(wire::number(code));
    events_.report({.kind = msg::EventKind::refused,
                    .axis = axis,
                    .session = session,
                    .code = wire::number(code),
                    .detail = RefusedMessage{.number = reply.request_id}});
  }
  if (reply.reason != msg::Reason::wrong_incarnation) keep(reply);
}

/// Keeps the answer without its statuses, of which there may be very many.
void RequestAnswers::keep(const msg::Reply& reply) {
  if (auto* const kept = memory_.keep(reply.client, reply.request_id)) kept->keep(reply);
}

Fate RequestAnswers::fate_of(const msg::Request& request) const noexcept {
  return memory_.fate_of(request.client, request.request_id);
}

void RequestAnswers::take(const msg::Request& request) {
  memory_.take(request.client, request.request_id);
}

/// Sends the kept answer; for a step, with the present statuses. If the answer is no longer kept,
/// refuses the request: carrying it out a second time would be worse.
void RequestAnswers::repeat(const Arrival& arrival) {
  OutgoingReply* const outgoing = open();
  if (outgoing == nullptr) return;
  const auto& request = arrival.request;
  begin(arrival, *outgoing);
  auto& reply = outgoing->reply;
  if (fate_of(request) == Fate::answered) {
    memory_.answer_to(request.client, request.request_id)->show(reply);
    const bool shows =
        reply.reason == msg::Reason::none || reply.reason == msg::Reason::missing_stepper;
    if (request.kind == msg::RequestKind::step && shows && !unknown_axis(request)) {
      add_statuses(request, *outgoing);
    }
  } else {
    finish(request.session, msg::Reason::too_late, reply);
  }
  push();
}

void RequestAnswers::add_statuses(const msg::Request& request, OutgoingReply& outgoing) const {
  const auto& numbers = request.axes;
  outgoing.axes.resize(numbers.size());
  for (std::size_t place = 0; place < numbers.size(); ++place) {
    const std::size_t axis = axes_.index_of_checked(numbers[place]);
    // Filled in place: copying what was just written would stall the processor.
    wire::ShownAxis& shown = outgoing.axes[place];
    shown.number = numbers[place];
    shown.tick = clock_.tick();
    shown.owner = masters_.owner(axis);
    shown.status = axes_.bank().status(axis);
  }
}

}  // namespace vdrive::service
