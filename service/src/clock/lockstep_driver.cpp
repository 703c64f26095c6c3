// SPDX-License-Identifier: Apache-2.0
#include "clock/lockstep_driver.hpp"

#include <utility>

namespace vdrive::service {
namespace {

/// Answers to stores and frames are also delivered during a long step, at this interval.
constexpr std::uint64_t kTicksPerDelivery = 64;

}  // namespace

LockstepDriver::LockstepDriver(const Configuration& configuration, BenchEngine& engine,
                               Inbox& inbox, Outbox& outbox, StatusPublisher& status,
                               ReplyPublisher& replies, const std::atomic<bool>& stop,
                               Doorbell& doorbell)
    : engine_(engine),
      steps_(engine.steps()),
      inbox_(inbox),
      outbox_(outbox),
      status_(status),
      replies_(replies),
      stop_(stop),
      doorbell_(doorbell),
      status_every_(configuration.status_every) {}

void LockstepDriver::run() {
  begin();
  while (!stop_) {
    if (round()) continue;
    const auto patience = replies_.is_waiting() ? kReplyInterval : kIdleInterval;
    if (!doorbell_.wait_for(patience)) idle();
  }
}

void LockstepDriver::begin() {
  publish_status();
}

bool LockstepDriver::round() {
  beats_.add();
  const auto now = Clock::now();
  const bool was_busy = handle_next(now);
  const bool has_moved = advance_time(now);
  const bool has_stored = engine_.answer_stores();
  if (was_busy || has_moved || outbox_.replies.size() > 0) deliver();
  if (has_moved) publish_status();  // after the reply, which is all that the client waits for
  return was_busy || has_stored;
}

/// @return whether there was anything to handle.
bool LockstepDriver::handle_next(Clock::time_point now) {
  if (steps_.holds_requests_back()) return handle_frames_only(now);
  if (!deferred_.empty()) {
    Arrival arrival = std::move(deferred_.front());
    deferred_.pop_front();
    handle(arrival, now);
    return true;
  }
  Arrival* const arrival = inbox_.front();
  if (arrival == nullptr) return false;
  handle(*arrival, now);
  inbox_.pop();
  return true;
}

/// Handles arrivals while a step waits for its frames. Requests that arrive before these frames are
/// kept and carried out after the step.
bool LockstepDriver::handle_frames_only(Clock::time_point now) {
  Arrival* const arrival = inbox_.front();
  if (arrival == nullptr) return false;
  if (arrival->kind == Arrival::Kind::command_frame) {
    handle(*arrival, now);
  } else if (deferred_.size() < kMostDeferred) {
    deferred_.push_back(std::move(*arrival));
  } else {
    return false;
  }
  inbox_.pop();
  return true;
}

void LockstepDriver::handle(Arrival& arrival, Clock::time_point now) {
  const bool is_request = arrival.kind == Arrival::Kind::request;
  steps_.note_message(is_request ? arrival.request.session : arrival.frame.session, now);
  if (StepRequests::is_for(arrival)) {
    steps_.handle(arrival, now);
  } else {
    engine_.handle(arrival);
    engine_.queue_changes();
    publish_queued();  // a restored state has to be published even if no step follows
  }
}

/// Lets time pass as far as the steps allow, and answers each step in its tick.
/// @return whether time has passed
bool LockstepDriver::advance_time(Clock::time_point now) {
  bool has_moved = false;
  for (std::uint64_t ticks = steps_.ticks_to_run(now); ticks > 0 && !stop_;
       ticks = steps_.ticks_to_run(now)) {
    run_ticks(ticks);
    answer_steps(now);
    has_moved = true;
  }
  answer_steps(now);
  if (now >= next_check_) {
    remove_absent(now);
    next_check_ = now + kCheckInterval;
  }
  return has_moved;
}

/// Runs the ticks; stops early when the service ends.
void LockstepDriver::run_ticks(std::uint64_t ticks) {
  for (std::uint64_t count = 1; count <= ticks; ++count) {
    steps_.begin_tick();
    engine_.step();
    beats_.add();
    const bool last = count == ticks;
    if (!last && engine_.tick() % status_every_ == 0 && may_publish()) publish_status();
    if (stop_) return;
    if (count % kTicksPerDelivery == 0) deliver();
  }
}

/// Delivers some answers before all are queued, because the queue may be too small for all steps
/// due in one tick and all stores that became durable.
void LockstepDriver::answer_steps(Clock::time_point now) {
  deliver_until([&] {
    return steps_.answer_due(now);
  });
}

void LockstepDriver::end() {
  deliver_until([&] {
    return steps_.refuse_waiting();
  });
}

/// Delivers answers until `is_done`, or until the wire accepts no further one.
template <typename IsDone>
void LockstepDriver::deliver_until(const IsDone& is_done) {
  while (!is_done()) {
    deliver();
    if (outbox_.replies.size() == outbox_.replies.capacity()) return;
  }
}

void LockstepDriver::remove_absent(Clock::time_point now) {
  steps_.remove_absent(now, [this](const wire::Source& source) {
    if (replies_.is_gone(source)) return ReaderState::gone;
    return replies_.is_matched(source) ? ReaderState::matched : ReaderState::unknown;
  });
}

/// Limits the rate of status frames during a long step, in wall time.
bool LockstepDriver::may_publish() {
  shown_ticks_.refill(Clock::now().time_since_epoch());
  return shown_ticks_.take();
}

void LockstepDriver::publish_status(bool repeated) {
  if (status_.has_readers()) {
    engine_.queue_status(repeated);
  } else {
    status_.leave_out(engine_.tick());
  }
  publish_queued();
}

void LockstepDriver::publish_queued() {
  while (const StatusImage* const image = outbox_.status.front()) {
    status_.publish(*image);
    outbox_.status.pop();
  }
}

/// Repeats the status while nothing moves, for clients that join later.
void LockstepDriver::idle() {
  engine_.queue_changes();
  deliver();
  publish_status(true);
}

}  // namespace vdrive::service
