// SPDX-License-Identifier: Apache-2.0
#include "clock/lockstep_driver.hpp"

#include <utility>

namespace vdrive::service {
namespace {

constexpr std::uint64_t kTicksPerDelivery = 64;

}  // namespace

LockstepDriver::LockstepDriver(const Configuration& configuration, BenchEngine& engine,
                               Inbox& inbox, Outbox& outbox, StatusPublisher& status,
                               ReplyPublisher& replies, Counters& counters)
    : engine_(engine),
      inbox_(inbox),
      outbox_(outbox),
      status_(status),
      replies_(replies),
      counters_(counters),
      status_every_(configuration.status_every) {}

void LockstepDriver::run(const std::atomic<bool>& stop, Doorbell& doorbell) {
  publish_status();
  while (!stop) {
    beats_.add();
    const bool was_busy = handle_next(stop, doorbell);
    advance(stop);
    const bool has_stored = engine_.answer_stores();
    if (has_stored) replies_.deliver(inbox_, outbox_);
    if (was_busy || has_stored) continue;
    const auto patience = replies_.is_waiting() ? kReplyInterval : kIdleInterval;
    if (!doorbell.wait_for(patience)) idle();
  }
  refuse_waiting();
}

bool LockstepDriver::handle_next(const std::atomic<bool>& stop, Doorbell& doorbell) {
  if (!deferred_.empty()) {
    Arrival arrival = std::move(deferred_.front());
    deferred_.pop_front();
    handle(arrival, stop, doorbell);
    return true;
  }
  Arrival* const arrival = inbox_.front();
  if (arrival == nullptr) return false;
  const bool is_step =
      arrival->kind == Arrival::Kind::request && arrival->request.kind() == msg::REQUEST_STEP;
  if (is_step) {  // it may have to read the messages that follow it in the inbox
    Arrival request = std::move(*arrival);
    inbox_.pop();
    handle(request, stop, doorbell);
  } else {
    handle(*arrival, stop, doorbell);
    inbox_.pop();
  }
  return true;
}

void LockstepDriver::handle(Arrival& arrival, const std::atomic<bool>& stop, Doorbell& doorbell) {
  const bool is_request = arrival.kind == Arrival::Kind::request;
  if (!steppers_.empty()) {
    steppers_.note_message(is_request ? arrival.request.session() : arrival.frame.session(),
                           Clock::now());
  }
  const std::uint32_t kind = is_request ? arrival.request.kind() : 0;
  const bool is_of_clock = kind == msg::REQUEST_STEP || kind == msg::REQUEST_JOIN_CLOCK ||
                           kind == msg::REQUEST_LEAVE_CLOCK;
  if (is_of_clock && engine_.answer_repeat(arrival)) {
    replies_.deliver(inbox_, outbox_);
    return;
  }
  if (kind == msg::REQUEST_STEP) {
    step(arrival, stop, doorbell);
    return;
  }
  if (kind == msg::REQUEST_JOIN_CLOCK) {
    join(arrival);
  } else if (kind == msg::REQUEST_LEAVE_CLOCK) {
    leave(arrival);
  } else {
    engine_.handle(arrival);
    engine_.post_parameters();
  }
  replies_.deliver(inbox_, outbox_);
}

void LockstepDriver::step(Arrival& arrival, const std::atomic<bool>& stop, Doorbell& doorbell) {
  const std::uint32_t reason = engine_.check_step(arrival);
  if (reason != msg::REASON_NONE) {
    answer(arrival, reason);
    replies_.deliver(inbox_, outbox_);
  } else if (steppers_.empty()) {
    step_at_once(arrival, stop, doorbell);
  } else {
    put_aside(arrival);
  }
}

void LockstepDriver::step_at_once(const Arrival& arrival, const std::atomic<bool>& stop,
                                  Doorbell& doorbell) {
  const bool complete = wait_for_commands(arrival.request, stop, doorbell);
  std::uint32_t reason = msg::REASON_NONE;
  if (complete) {
    stepping_.assign(1, arrival.request.session());
    if (!run_ticks(arrival.request.ticks(), stop)) reason = msg::REASON_SHUTTING_DOWN;
  } else {
    reason = stop ? msg::REASON_SHUTTING_DOWN : msg::REASON_MISSING_COMMANDS;
  }
  answer(arrival, reason);
  replies_.deliver(inbox_, outbox_);
  if (reason == msg::REASON_NONE && arrival.request.ticks() > 0) publish_status();
}

/// Many may be answered in one tick, beside the stores that became durable.
void LockstepDriver::answer(const Arrival& arrival, std::uint32_t reason,
                            std::uint64_t missing_stepper) {
  if (outbox_.replies.free_slot() == nullptr) replies_.deliver(inbox_, outbox_);
  engine_.answer_step(arrival, reason, missing_stepper);
}

/// The frames come on another topic than the step: they may be behind it.
bool LockstepDriver::wait_for_commands(const msg::Request& request, const std::atomic<bool>& stop,
                                       Doorbell& doorbell) {
  const auto deadline = Clock::now() + kLongestWaitForCommands;
  while (!engine_.has_arrived(request.session(), request.last_sequence())) {
    const auto left = deadline - Clock::now();
    if (stop || left <= Clock::duration::zero()) return false;
    if (!take_frames()) doorbell.wait_for(left);
  }
  return true;
}

/// Handles the frames at the head of the inbox and puts requests aside. @return whether there was
/// anything.
bool LockstepDriver::take_frames() {
  Arrival* const arrival = inbox_.front();
  if (arrival == nullptr) return false;
  if (arrival->kind == Arrival::Kind::command_frame) {
    engine_.handle(*arrival);
    replies_.deliver(inbox_, outbox_);
  } else if (deferred_.size() < kMostDeferred) {
    deferred_.push_back(std::move(*arrival));
  } else {
    return false;
  }
  inbox_.pop();
  return true;
}

bool LockstepDriver::run_ticks(std::uint64_t ticks, const std::atomic<bool>& stop) {
  for (std::uint64_t count = 1; count <= ticks; ++count) {
    for (const std::uint64_t session : stepping_) engine_.note_message(session);
    engine_.step();
    beats_.add();
    const bool last = count == ticks;
    if (!last && engine_.tick() % status_every_ == 0 && may_publish()) publish_status();
    if (stop && !last) return false;
    if (count % kTicksPerDelivery == 0) replies_.deliver(inbox_, outbox_);
  }
  return true;
}

/// Wall time decides how many of the ticks of a long step are shown.
bool LockstepDriver::may_publish() {
  shown_ticks_.refill(Clock::now().time_since_epoch());
  return shown_ticks_.take();
}

void LockstepDriver::publish_status(bool repeated) {
  engine_.post_status(repeated);
  while (const StatusImage* const image = outbox_.status.front()) {
    status_.publish(*image);
    outbox_.status.pop();
  }
}

/// While nothing moves: clients that join later see the axes, too.
void LockstepDriver::idle() {
  engine_.post_parameters();
  replies_.deliver(inbox_, outbox_);
  publish_status(true);
}

}  // namespace vdrive::service
