// SPDX-License-Identifier: Apache-2.0
// Steppers: sessions that joined the clock of a lock-step bench, and the steps that wait for them.
#include "clock/lockstep_driver.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::service {

void LockstepDriver::join(const Arrival& arrival) {
  const std::uint64_t session = arrival.request.session();
  std::uint32_t reason = engine_.check_step(arrival);
  if (reason == msg::REASON_NONE && session == 0) reason = msg::REASON_BAD_SESSION;
  if (reason == msg::REASON_NONE && steppers_.find(session) == nullptr) {
    if (steppers_.join(session, arrival.source, engine_.tick(), Clock::now())) {
      engine_.report(
          {.kind = msg::EVENT_CLOCK_CHANGED, .session = session, .code = msg::REQUEST_JOIN_CLOCK});
      show_steppers();
    } else {
      reason = msg::REASON_QUEUE_FULL;
    }
  }
  engine_.note_message(session);
  answer(arrival, reason);
}

void LockstepDriver::leave(const Arrival& arrival) {
  const std::uint64_t session = arrival.request.session();
  std::uint32_t reason = engine_.check_step(arrival);
  if (reason == msg::REASON_NONE && steppers_.find(session) == nullptr) {
    reason = msg::REASON_NOT_A_STEPPER;
  }
  if (reason == msg::REASON_NONE) part_with(session, Parting::left);
  engine_.note_message(session);
  answer(arrival, reason);
}

void LockstepDriver::part_with(std::uint64_t session, Parting parting) {
  steppers_.leave(session, Clock::now());
  engine_.report({.kind = msg::EVENT_CLOCK_CHANGED,
                  .session = session,
                  .code = msg::REQUEST_LEAVE_CLOCK,
                  .detail = parting});
  show_steppers();
}

/// A step of no ticks only observes: every session may request it.
void LockstepDriver::put_aside(Arrival& arrival) {
  const bool is_stepper = steppers_.find(arrival.request.session()) != nullptr;
  std::uint32_t reason = msg::REASON_NONE;
  if (!is_stepper && arrival.request.ticks() > 0) {
    reason = msg::REASON_NOT_A_STEPPER;
  } else if (waiting_.size() == kMostDeferred) {
    reason = msg::REASON_QUEUE_FULL;
  }
  if (reason != msg::REASON_NONE) {
    answer(arrival, reason);
    replies_.deliver(inbox_, outbox_);
    return;
  }
  waiting_.push_back(
      {.arrival = std::move(arrival), .deadline = Clock::now() + kLongestWaitForCommands});
}

/// Lets time pass as far as all steppers grant it, and answers each step in its tick.
void LockstepDriver::advance(const std::atomic<bool>& stop) {
  if (steppers_.empty() && waiting_.empty()) return;
  const auto now = Clock::now();
  grant_arrived(now);
  bool has_moved = false;
  for (std::uint64_t ticks = ticks_to_go(); ticks > 0 && !stop; ticks = ticks_to_go()) {
    stepping_.clear();
    for (const Stepper& stepper : steppers_.all()) stepping_.push_back(stepper.session);
    run_ticks(ticks, stop);
    has_moved = true;
    answer_due(now);
  }
  answer_due(now);
  if (now >= next_check_) {
    remove_absent(now);
    next_check_ = now + kCheckInterval;
  }
  show_steppers();
  replies_.deliver(inbox_, outbox_);
  if (has_moved) publish_status();
}

/// A step grants its ticks once the command frames that were sent before it are here.
void LockstepDriver::grant_arrived(Clock::time_point now) {
  for (WaitingStep& waiting : waiting_) {
    const msg::Request& request = waiting.arrival.request;
    if (waiting.is_granted || !engine_.has_arrived(request.session(), request.last_sequence())) {
      continue;
    }
    waiting.is_granted = true;
    waiting.deadline = now + kLongestWaitForSteppers;
    waiting.aim = engine_.tick();
    Stepper* const stepper = steppers_.find(request.session());
    waiting.is_of_stepper = stepper != nullptr || request.ticks() > 0;
    if (stepper != nullptr) {
      steppers_.grant(*stepper, request.ticks(), now);
      waiting.aim = stepper->granted;
    } else if (waiting.is_of_stepper) {  // it was one when it sent the request
      waiting.aim = engine_.tick() + 1;
    }
  }
}

/// @return how many ticks may pass until a step is to be answered.
std::uint64_t LockstepDriver::ticks_to_go() const {
  const Stepper* const slowest = steppers_.slowest();
  if (slowest == nullptr) return 0;
  std::uint64_t limit = slowest->granted;
  for (const WaitingStep& waiting : waiting_) {
    if (waiting.is_granted && waiting.aim > engine_.tick()) limit = std::min(limit, waiting.aim);
  }
  return limit - engine_.tick();
}

void LockstepDriver::answer_due(Clock::time_point now) {
  std::erase_if(waiting_, [&](const WaitingStep& waiting) {
    return answer_if_due(waiting, now);
  });
}

bool LockstepDriver::answer_if_due(const WaitingStep& waiting, Clock::time_point now) {
  const bool is_late = now >= waiting.deadline;
  if (!waiting.is_granted) {
    if (is_late) answer(waiting.arrival, msg::REASON_MISSING_COMMANDS);
    return is_late;
  }
  if (engine_.tick() >= waiting.aim) {
    answer(waiting.arrival, msg::REASON_NONE);
    return true;
  }
  if (waiting.is_of_stepper && steppers_.find(waiting.arrival.request.session()) == nullptr) {
    answer(waiting.arrival, msg::REASON_NOT_A_STEPPER);
    return true;
  }
  if (is_late) answer(waiting.arrival, msg::REASON_MISSING_STEPPER, steppers_.slowest()->session);
  return is_late;
}

/// For steps that no tick will answer.
void LockstepDriver::refuse_waiting() {
  for (const WaitingStep& waiting : waiting_) answer(waiting.arrival, msg::REASON_SHUTTING_DOWN);
  waiting_.clear();
}

/// Takes steppers off the clock that are not there any more: a program that died must not stop
/// the time of the others for good.
void LockstepDriver::remove_absent(Clock::time_point now) {
  std::vector<std::uint64_t> gone;
  for (Stepper& stepper : steppers_.all()) {
    if (stepper.was_matched && replies_.is_gone(stepper.source)) gone.push_back(stepper.session);
    stepper.was_matched = stepper.was_matched || replies_.is_matched(stepper.source);
  }
  for (const std::uint64_t session : gone) part_with(session, Parting::gone);
  while (const Stepper* const stepper = steppers_.silent(now)) {
    part_with(stepper->session, Parting::silent);
  }
}

void LockstepDriver::show_steppers() {
  const Stepper* const slowest = steppers_.slowest();
  counters_.steppers.set(steppers_.size());
  counters_.slowest_stepper.set(slowest == nullptr ? 0 : slowest->session);
}

}  // namespace vdrive::service
