// SPDX-License-Identifier: Apache-2.0
#include "execution/value_observer.hpp"

#include "vdrive/assert.hpp"

#include <chrono>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;

// Only a bench that is lost ends the wait: next() begins again.
constexpr std::chrono::milliseconds kPatienceOfObserver{500};

}  // namespace

Outcome ValueObserver::start(const client::BenchInfo& bench, std::uint64_t in_force) {
  is_lockstep_ = bench.clock_mode == client::ClockMode::lockstep;
  auto follower = session_.follow({axis_.id()}, client::Pace::drive);
  if (!follower) return follower.outcome();
  follower_ = std::move(*follower);
  const client::AxisId id = axis_.id();
  if (Outcome seen = see(session_.observe({&id, 1})); !seen) return seen;
  while (tick_ < in_force) {
    if (Outcome seen = next(); !seen) return seen;
  }
  missed_ = 0;
  return {};
}

Outcome ValueObserver::next() {
  ensure(follower_.has_value(), "the observer was started");
  while (true) {
    auto sample = follower_->next(kPatienceOfObserver);
    // A busy machine: the end of the wait is up to the caller.
    if (sample.outcome().kind() == client::OutcomeKind::timed_out) continue;
    return see(std::move(sample));
  }
}

Outcome ValueObserver::see(client::Result<client::Observation> sample) {
  if (!sample) return sample.outcome();
  ensure(!sample->axes.empty(), "an observation has the axis that is observed");
  tick_ = sample->tick;
  missed_ += sample->missed;
  shown_ = sample->axes.front();
  const auto streamed = client::value_of(shown_, object_);
  is_streamed_ = streamed.has_value();
  if (streamed) {
    value_ = *streamed;
    return {};
  }
  const auto read = axis_.read(object_);
  if (!read) return read.outcome();
  value_ = *read;
  return {};
}

}  // namespace vdrive::tool
