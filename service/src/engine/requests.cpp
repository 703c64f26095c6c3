// SPDX-License-Identifier: Apache-2.0
#include "engine/requests.hpp"

namespace vdrive::service {

Requests::Requests(BenchClock& clock, MasterWatch& watch, const BenchBrake& brake,
                   const Parts& parts, RequestAnswers& answers, BenchEvents& events)
    : clock_(clock),
      watch_(watch),
      brake_(brake),
      parts_(parts),
      answers_(answers),
      events_(events) {}

void Requests::handle(const Arrival& arrival) {
  OutgoingReply* const outgoing = answers_.open();
  if (outgoing == nullptr) return;  // nothing is done that could not be answered
  if (answer_repeat(arrival)) return;
  answers_.begin(arrival, *outgoing);
  const msg::Request& request = arrival.request;
  Reason reason = check(arrival);
  parts_.stores.begin_request();
  if (reason == msg::REASON_NONE) reason = carry_out(request, outgoing->reply);
  if (parts_.stores.has_ordered()) {
    parts_.stores.wait(request.session(), reason, *outgoing);
    return;
  }
  answers_.finish(request.session(), reason, outgoing->reply);
  answers_.push();
}

bool Requests::answer_repeat(const Arrival& arrival) {
  const auto& request = arrival.request;
  if (request.client() == 0 || !answers_.is_of_this_run(request)) return false;  // it is refused
  const Fate fate = answers_.fate_of(request);
  if (fate == Fate::unknown) {
    answers_.take(request);
    return false;
  }
  if (arrival.refusal == msg::REASON_NONE) parts_.masters.note_message(request.session());
  const bool is_in_progress =
      fate == Fate::taken || (fate == Fate::forgotten && parts_.stores.is_waiting(request));
  if (!is_in_progress) answers_.repeat(arrival);
  return true;
}

Reason Requests::check(const Arrival& arrival) const {
  const auto& request = arrival.request;
  if (request.client() == 0) return msg::REASON_BAD_SESSION;
  if (!answers_.is_of_this_run(request)) return msg::REASON_WRONG_INCARNATION;
  if (brake_.is_engaged() && request.kind() != msg::REQUEST_READ) return msg::REASON_SHUTTING_DOWN;
  return arrival.refusal;
}

Reason Requests::carry_out(const msg::Request& request, msg::Reply& reply) {
  parts_.masters.note_message(request.session());
  switch (request.kind()) {
    case msg::REQUEST_READ:
      return parts_.axes.read(request, reply);
    case msg::REQUEST_WRITE:
      return parts_.axes.write(request, reply);
    case msg::REQUEST_POWER_CYCLE:
      return parts_.axes.power_cycle(request, reply);
    case msg::REQUEST_ACQUIRE:
      return parts_.masters.acquire(request, false, reply);
    case msg::REQUEST_TAKE_OVER:
      return parts_.masters.acquire(request, true, reply);
    case msg::REQUEST_RELEASE:
      return parts_.masters.release(request, reply);
    case msg::REQUEST_STORE:
    case msg::REQUEST_RESTORE:
      return parts_.stores.store_axes(request, reply);
    case msg::REQUEST_TAKE_SNAPSHOT:
      return parts_.snapshots.take(request, reply);
    case msg::REQUEST_RESTORE_SNAPSHOT:
      return parts_.snapshots.restore(request, reply);
    case msg::REQUEST_DROP_SNAPSHOT:
      return parts_.snapshots.drop(request);
    case msg::REQUEST_NEXT_SNAPSHOT:
      return parts_.snapshots.show_next(request, reply);
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

/// Any session may: time belongs to all.
Reason Requests::set_rate(const msg::Request& request) {
  if (clock_.mode() != ClockMode::realtime) return msg::REASON_WRONG_CLOCK_MODE;
  const double rate = request.rate();
  if (!(rate == 0.0 || (rate >= kLowestRate && rate <= kHighestRate))) {  // NaN too
    return msg::REASON_OUT_OF_RANGE;
  }
  if (rate == clock_.rate()) return msg::REASON_NONE;
  clock_.set_rate(rate);
  watch_.follow_rate();
  events_.report({.kind = msg::EVENT_CLOCK_CHANGED,
                  .session = request.session(),
                  .code = msg::REQUEST_SET_RATE,
                  .detail = NewRate{clock_.rate()}});
  return msg::REASON_NONE;
}

}  // namespace vdrive::service
