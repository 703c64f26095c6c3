// SPDX-License-Identifier: Apache-2.0
#include "engine/step_requests.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::service {

static_assert(kMaxSteppers == msg::MAX_STEPPERS, "the wire promises it");

StepRequests::StepRequests(const Configuration& configuration, const BenchClock& clock,
                           const CommandFrames& frames, Masters& masters, Requests& requests,
                           RequestAnswers& answers, BenchEvents& events, Counters& counters)
    : clock_(clock),
      frames_(frames),
      masters_(masters),
      requests_(requests),
      answers_(answers),
      events_(events),
      counters_(counters),
      steppers_(configuration.steppers) {}

bool StepRequests::handle(Arrival& arrival, Time now) {
  if (requests_.answer_repeat(arrival)) return false;
  const std::uint64_t session = arrival.request.session;
  const msg::RequestKind kind = arrival.request.kind;
  Reason reason = check(arrival);
  if (kind == msg::RequestKind::step) {
    if (reason == msg::Reason::none) reason = keep(arrival, now);
    if (reason == msg::Reason::none) return true;  // answer_due() answers it
  } else {
    if (reason == msg::Reason::none) reason = change_steppers(arrival, now);
    masters_.note_message(session);
  }
  answer(arrival, reason);
  return true;
}

Reason StepRequests::check(const Arrival& arrival) const {
  const auto& request = arrival.request;
  if (const auto reason = requests_.check(arrival); reason != msg::Reason::none) return reason;
  if (const auto reason = requests_.check_kind(request); reason != msg::Reason::none) return reason;
  if (request.ticks > kMaxTicksPerStep) return msg::Reason::too_many_ticks;
  if (request.session == 0 && request.last_sequence != 0) return msg::Reason::bad_session;
  if (answers_.unknown_axis(request)) return msg::Reason::unknown_axis;
  return msg::Reason::none;
}

/// A step of 0 ticks only observes, so every session may request it even while there are steppers.
Reason StepRequests::keep(Arrival& arrival, Time now) {
  const bool is_alone = steppers_.is_open();
  const bool is_stepper = steppers_.find(arrival.request.session) != nullptr;
  if (!is_alone && !is_stepper && arrival.request.ticks > 0) return msg::Reason::not_a_stepper;
  if (waiting_.size() == kMostWaiting) return msg::Reason::queue_full;
  waiting_.push_back({.arrival = std::move(arrival),
                      .deadline = now + kLongestWaitForCommands,
                      .is_alone = is_alone});
  return msg::Reason::none;
}

Reason StepRequests::join(const Arrival& arrival, Time now) {
  const std::uint64_t session = arrival.request.session;
  if (session == 0) return msg::Reason::bad_session;
  if (steppers_.find(session) != nullptr) return msg::Reason::none;
  const std::uint64_t awaited = arrival.request.ticks;
  if (awaited > kMaxSteppers ||
      !steppers_.join(session, arrival.source, clock_.tick(), now, awaited)) {
    return msg::Reason::too_many_steppers;
  }
  events_.report({.kind = msg::EventKind::clock_changed,
                  .session = session,
                  .code = wire::number(msg::RequestKind::join_clock)});
  show_steppers();
  return msg::Reason::none;
}

Reason StepRequests::change_steppers(const Arrival& arrival, Time now) {
  switch (arrival.request.kind) {
    case msg::RequestKind::join_clock:
      return join(arrival, now);
    case msg::RequestKind::leave_clock:
      return leave(arrival, now);
    default:
      return msg::Reason::unknown_kind;
  }
}

Reason StepRequests::leave(const Arrival& arrival, Time now) {
  const std::uint64_t session = arrival.request.session;
  if (steppers_.find(session) == nullptr) return msg::Reason::not_a_stepper;
  remove_stepper(session, StepperRemoval::left, now);
  return msg::Reason::none;
}

void StepRequests::remove_stepper(std::uint64_t session, StepperRemoval parting, Time now) {
  steppers_.leave(session, now);
  events_.report({.kind = msg::EventKind::clock_changed,
                  .session = session,
                  .code = wire::number(msg::RequestKind::leave_clock),
                  .detail = parting});
  show_steppers();
}

std::uint64_t StepRequests::ticks_to_run(Time now) {
  if (waiting_.empty()) return 0;  // only steps grant ticks
  grant_arrived(now);
  const std::uint64_t tick = clock_.tick();
  const Stepper* const slowest = steppers_.slowest();
  std::uint64_t limit = tick;
  if (slowest != nullptr && steppers_.is_complete()) limit = slowest->granted;
  if (holds_requests_back() && waiting_.back().is_granted) limit = waiting_.back().aim;
  for (const WaitingStep& waiting : waiting_) {
    if (waiting.is_granted && waiting.aim > tick) limit = std::min(limit, waiting.aim);
  }
  return limit - tick;
}

/// A step grants its ticks once the command frames that were sent before it have arrived: they use
/// another topic and may arrive after it.
void StepRequests::grant_arrived(Time now) {
  for (WaitingStep& waiting : waiting_) {
    const msg::Request& request = waiting.arrival.request;
    if (!waiting.is_granted && frames_.has_arrived(request.session, request.last_sequence)) {
      grant(waiting, now);
    }
  }
}

void StepRequests::grant(WaitingStep& waiting, Time now) {
  const msg::Request& request = waiting.arrival.request;
  waiting.is_granted = true;
  waiting.deadline = now + kLongestWaitForSteppers;
  waiting.aim = clock_.tick();
  if (waiting.is_alone) {
    waiting.aim += request.ticks;
    return;
  }
  Stepper* const stepper = steppers_.find(request.session);
  waiting.is_of_stepper = stepper != nullptr || request.ticks > 0;
  if (stepper != nullptr) {
    steppers_.grant(*stepper, request.ticks, now);
    waiting.aim = stepper->granted;
    show_steppers();
  } else if (waiting.is_of_stepper) {  // it was a stepper when it sent the request
    waiting.aim = clock_.tick() + 1;
  }
}

void StepRequests::begin_tick() {
  if (holds_requests_back()) masters_.note_message(waiting_.back().arrival.request.session);
  for (const Stepper& stepper : steppers_.all()) masters_.note_message(stepper.session);
}

bool StepRequests::answer_due(Time now) {
  bool has_room = true;
  std::erase_if(waiting_, [&](const WaitingStep& waiting) {
    has_room = has_room && answers_.has_room();
    return has_room && answer_if_due(waiting, now);
  });
  return has_room;
}

bool StepRequests::answer_if_due(const WaitingStep& waiting, Time now) {
  const bool is_late = now >= waiting.deadline;
  if (!waiting.is_granted) {
    if (is_late) answer(waiting.arrival, msg::Reason::missing_commands);
    return is_late;
  }
  if (clock_.tick() >= waiting.aim) {
    answer(waiting.arrival, msg::Reason::none);
    return true;
  }
  if (waiting.is_alone) return false;  // its ticks do not depend on others
  if (waiting.is_of_stepper && steppers_.find(waiting.arrival.request.session) == nullptr) {
    answer(waiting.arrival, msg::Reason::not_a_stepper);
    return true;
  }
  if (!is_late) return false;
  const Stepper* const slowest = steppers_.slowest();
  ensure(slowest != nullptr, "a step that waits for time has a stepper");
  answer(waiting.arrival, msg::Reason::missing_stepper,
         steppers_.is_complete() ? slowest->session : 0);
  return true;
}

bool StepRequests::refuse_waiting() {
  while (!waiting_.empty() && answers_.has_room()) {
    answer(waiting_.front().arrival, msg::Reason::shutting_down);
    waiting_.pop_front();
  }
  return waiting_.empty();
}

void StepRequests::answer(const Arrival& arrival, Reason reason, std::uint64_t missing_stepper) {
  OutgoingReply* const outgoing = answers_.open();
  if (outgoing == nullptr) return;
  answers_.begin(arrival, *outgoing);
  auto& reply = outgoing->reply;
  reply.missing_stepper = missing_stepper;
  const msg::Request& request = arrival.request;
  if (reason == msg::Reason::none || reason == msg::Reason::missing_stepper) {
    answers_.add_statuses(request, *outgoing);
  } else if (reason == msg::Reason::unknown_axis) {
    masters_.name_refused(*answers_.unknown_axis(request), reply);
  }
  answers_.finish(request.session, reason, reply);
  answers_.push();
}

void StepRequests::remove_absent(Time now,
                                 const std::function<ReaderState(const wire::Source&)>& reader_of) {
  std::vector<std::uint64_t> gone;
  for (Stepper& stepper : steppers_.all()) {
    const ReaderState state = reader_of(stepper.source);
    if (stepper.was_matched && state == ReaderState::gone) gone.push_back(stepper.session);
    stepper.was_matched = stepper.was_matched || state == ReaderState::matched;
  }
  for (const std::uint64_t session : gone) remove_stepper(session, StepperRemoval::gone, now);
  while (const Stepper* const stepper = steppers_.silent(now)) {
    remove_stepper(stepper->session, StepperRemoval::silent, now);
  }
}

void StepRequests::show_steppers() {
  const Stepper* const slowest = steppers_.slowest();
  counters_.steppers.set(steppers_.size());
  const bool is_waited_for = slowest != nullptr && steppers_.is_complete();
  counters_.slowest_stepper.set(is_waited_for ? slowest->session : 0);
}

}  // namespace vdrive::service
