// SPDX-License-Identifier: Apache-2.0
#include "state_times.hpp"

#include <algorithm>

namespace vdrive::ros2 {
namespace {

using std::chrono::milliseconds;

// A bench in lock-step that does not advance is looked at so often: the end of its step is due.
constexpr milliseconds kSilentTurn{10};
constexpr milliseconds kEndOfStep{20};  // no further tick came: the step has ended

// A node that joins while no tick passes has to see the joints, too: it may read best effort, and
// its match tells nothing about the samples that reach it.
constexpr std::chrono::seconds kRepeat{1};

}  // namespace

bool StateTimes::take(const client::BenchInfo& bench, std::uint64_t tick, Clock::time_point now) {
  Published& published = published_[bench.number];
  // The first state of a run is published at once, whatever its tick is.
  if (published.incarnation != bench.incarnation) {
    published = {.incarnation = bench.incarnation, .tick = tick + 1, .due = now};
  }
  if (!is_due(published, bench, tick, now)) return false;
  published.tick = tick;
  published.taken = now;
  return true;
}

bool StateTimes::is_due(Published& published, const client::BenchInfo& bench, std::uint64_t tick,
                        Clock::time_point now) const {
  if (tick == published.tick) return now - published.taken >= kRepeat;
  return bench.clock_mode == client::ClockMode::lockstep
             ? is_due_in_lockstep(published, bench, tick, now)
             : is_due_at_rate(published, now);
}

bool StateTimes::is_due_at_rate(Published& published, Clock::time_point now) const {
  if (now < published.due) return false;
  // A late message does not shift those that follow, unless it is later than a whole period.
  published.due += period_;
  if (published.due < now) published.due = now + period_;
  return true;
}

bool StateTimes::is_due_in_lockstep(Published& published, const client::BenchInfo& bench,
                                    std::uint64_t tick, Clock::time_point now) const {
  if (tick != published.waiting) {
    published.waiting = tick;
    published.waiting_since = now;
  }
  // In doubles: the bench may count from a lower number.
  const double passed = (static_cast<double>(tick) - static_cast<double>(published.tick)) *
                        std::chrono::duration<double>(bench.period).count();
  return passed * rate_ >= 1.0 || passed < 0.0 || now - published.waiting_since >= kEndOfStep;
}

StateTimes::Clock::time_point StateTimes::next(Clock::time_point now) const {
  Clock::time_point next = now + std::min<Clock::duration>(period_, kSilentTurn);
  for (const auto& [number, published] : published_) {
    if (published.due > now) next = std::min(next, published.due);
  }
  return next;
}

}  // namespace vdrive::ros2
