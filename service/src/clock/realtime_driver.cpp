// SPDX-License-Identifier: Apache-2.0
#include "clock/realtime_driver.hpp"

#include "base/event_codes.hpp"

namespace vdrive::service {

RealtimeDriver::RealtimeDriver(const Configuration& configuration, BenchEngine& engine,
                               Inbox& inbox, Counters& counters, CycleTimer& timer)
    : engine_(engine),
      inbox_(inbox),
      counters_(counters),
      timer_(timer),
      period_(configuration.period),
      status_every_(configuration.status_every),
      wall_step_policy_(configuration.clock_step),
      rate_(configuration.rate) {
  const Instant now{timer.monotonic_now(), timer.wall_now()};
  engine_.start_at(
      static_cast<std::uint64_t>(now.wall / std::chrono::nanoseconds(configuration.period)));
  if (configuration.rate > 0.0) {
    clock_.emplace(period_, configuration.rate, now, wall_step_policy_);
    next_cycle_ = clock_->deadline().count();
  } else {
    engine_.queue_status();
    next_cycle_ = (now.monotonic + period_).count();
  }
}

void RealtimeDriver::cycle() noexcept {
  timer_.wait_until(next_cycle());
  handle_arrivals();
  if (engine_.rate() != rate_) {
    change_rate();
  } else if (clock_) {
    tick();
    next_cycle_.store(clock_->deadline().count(), std::memory_order_relaxed);
  } else {
    idle();
  }
}

/// Follows a rate that a request has set. The tick that was due now is rescheduled at that rate.
void RealtimeDriver::change_rate() noexcept {
  rate_ = engine_.rate();
  const Instant now{timer_.monotonic_now(), timer_.wall_now()};
  if (rate_ == 0.0) {
    clock_.reset();
    next_repeat_ = now.monotonic;
    if (const auto overruns = overruns_.flush(now.monotonic)) {
      engine_.report({.kind = msg::EventKind::tick_overrun, .detail = *overruns});
    }
  } else if (clock_) {
    clock_->set_rate(rate_, now);
  } else {
    clock_.emplace(period_, rate_, now, engine_.tick() + 1, wall_step_policy_);
  }
  counters_.wall_offset.set(0.0);
  const auto next = clock_ ? clock_->deadline() : now.monotonic + period_;
  next_cycle_.store(next.count(), std::memory_order_relaxed);
}

void RealtimeDriver::tick() noexcept {
  const auto begin = timer_.monotonic_now();
  static_cast<void>(clock_->skip_backlog(begin));
  if (const std::uint64_t missing = clock_->next_tick() - engine_.tick() - 1; missing > 0) {
    engine_.jump(missing);
  }
  counters_.count_lateness(begin - clock_->deadline());
  engine_.step();
  if (engine_.tick() % status_every_ == 0) engine_.queue_status();
  follow_wall_clock();
  const auto end = timer_.monotonic_now();
  const auto late = end - clock_->deadline();
  if (late > std::chrono::nanoseconds::zero()) counters_.overruns.add();
  if (const auto overruns = overruns_.note(end, late)) {
    engine_.report({.kind = msg::EventKind::tick_overrun, .detail = *overruns});
  }
}

void RealtimeDriver::follow_wall_clock() noexcept {
  if (const auto step = clock_->advance({timer_.monotonic_now(), timer_.wall_now()})) {
    const auto offset = std::chrono::duration_cast<std::chrono::microseconds>(step->offset);
    counters_.wall_steps.add();
    engine_.report({.kind = msg::EventKind::wall_clock,
                    .code = step->jumped > 0 ? WallClockCode::kJumped : WallClockCode::kSteered,
                    .detail = offset});
  }
  const std::chrono::duration<double> offset = clock_->offset();
  counters_.wall_offset.set(offset.count());
}

/// Repeats the status while paused, for clients that join later.
void RealtimeDriver::idle() noexcept {
  static_cast<void>(engine_.answer_stores());
  engine_.queue_changes();
  const auto now = timer_.monotonic_now();
  if (now >= next_repeat_) {
    engine_.queue_status(true);
    next_repeat_ = now + kRepeatInterval;
  }
  next_cycle_.store((now + period_).count(), std::memory_order_relaxed);
}

/// Arrivals that cannot be answered now wait in the inbox.
void RealtimeDriver::handle_arrivals() {
  for (std::size_t count = 0; count < kArrivalsPerTick && engine_.can_answer(); ++count) {
    Arrival* const arrival = inbox_.front();
    if (arrival == nullptr) return;
    engine_.handle(*arrival);
    inbox_.pop();
  }
}

}  // namespace vdrive::service
