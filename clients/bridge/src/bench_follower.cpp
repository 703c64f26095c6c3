// SPDX-License-Identifier: Apache-2.0
#include "bench_follower.hpp"

#include "vdrive/assert.hpp"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>

namespace vdrive::bridge {

using std::chrono::milliseconds;

bool BenchFollower::open(Clock::time_point now) {
  if (next_ || now < due_) return false;
  auto next = open_();
  if (!next) {
    due_ = now + kRetry;
    return false;
  }
  next_ = std::move(*next);
  return true;
}

std::optional<client::Observation> BenchFollower::next(milliseconds patience) {
  ensure(is_open(), "samples come while a bench is followed");
  auto sample = next_(patience);
  if (sample) return std::move(*sample);
  // The service fell silent, or another run has started.
  if (sample.outcome().kind() != client::OutcomeKind::timed_out) close();
  return std::nullopt;
}

std::optional<client::Observation> BenchFollower::newest(milliseconds patience) {
  auto newest = next(patience);
  while (newest) {
    auto next_one = next(milliseconds(0));
    if (!next_one) break;
    newest = std::move(next_one);
  }
  return newest;
}

std::vector<client::AxisId> ids_of(const client::BenchInfo& info) {
  std::vector<client::AxisId> ids;
  ids.reserve(info.axes.size());
  for (const client::AxisInfo& axis : info.axes) ids.push_back(axis.id);
  return ids;
}

BenchFollower::Open follow_axes(client::Session& session, std::vector<client::AxisId> axes) {
  return [&session, axes = std::move(axes)]() -> client::Result<BenchFollower::Next> {
    auto follower = session.follow(axes, client::Pace::observe);
    if (!follower) return follower.outcome();
    // Shared, because a std::function must be copyable and a follower is not.
    auto shared = std::make_shared<client::Follower>(std::move(*follower));
    return BenchFollower::Next([shared](milliseconds patience) {
      return shared->next(patience);
    });
  };
}

void rest(milliseconds duration, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, duration, [] {
    return false;
  });
}

}  // namespace vdrive::bridge
