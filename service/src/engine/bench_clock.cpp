// SPDX-License-Identifier: Apache-2.0
#include "engine/bench_clock.hpp"

#include <atomic>
#include <cmath>

namespace vdrive::service {

BenchClock::BenchClock(const Configuration& configuration, Counters& counters)
    : counters_(counters),
      mode_(configuration.clock),
      period_(configuration.period),
      rate_(mode_ == ClockMode::realtime ? configuration.rate : 0.0) {
  counters_.rate.set(rate_);
}

void BenchClock::start_at(std::uint64_t last_tick) {
  tick_ = last_tick;
  counters_.tick.set(tick_);
}

void BenchClock::complete_tick() {
  ++tick_;
  counters_.tick.set(tick_);
  counters_.ticks_run.add();
}

void BenchClock::jump(std::uint64_t ticks) {
  tick_ += ticks;
  skipped_ += ticks;
  counters_.tick.jump(tick_, skipped_);
  counters_.jumps.add();
}

void BenchClock::set_rate(double rate) {
  rate_ = std::abs(rate);  // no negative zero
  counters_.rate.set(rate_);
}

bool BenchClock::time_stands() const noexcept {
  return mode_ == ClockMode::lockstep || (mode_ == ClockMode::realtime && rate_ == 0.0);
}

std::uint64_t BenchClock::ticks_in(std::chrono::microseconds time) const noexcept {
  return static_cast<std::uint64_t>((time + period_ - std::chrono::microseconds{1}) / period_);
}

}  // namespace vdrive::service
