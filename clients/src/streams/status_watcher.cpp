// SPDX-License-Identifier: Apache-2.0
#include "streams/status_watcher.hpp"

#include "presence/target.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace vdrive::client {
namespace {

using Clock = Discovery::Clock;

// A period of 0 would keep a processor busy.
constexpr std::chrono::milliseconds kShortestPeriod{1};

// Between two periods when all reports have ended.
constexpr std::chrono::milliseconds kRest{1'000};

}  // namespace

/// The axes of one bench.
struct StatusWatcher::Bench {
  std::uint32_t number = 0;
  std::vector<std::uint16_t> axes;
  BenchKey key;
  std::shared_ptr<StatusFeed> feed;  ///< none until the bench is there
  std::optional<Clock::time_point> absent_since;
};

/// Follows the run of the service that is there now: a service that restarts is another run.
bool StatusWatcher::report(Bench& bench, const Observer& observe, const Ended& ended) const {
  const std::optional<Target> target = discovery_.present_target(bench.number);
  if (target) {
    bench.absent_since.reset();
    if (!bench.feed || bench.key != target->key) {
      bench.key = target->key;
      bench.feed = stream_.open_feed(*target, bench.axes);
    }
    if (const auto newest = stream_.take_newest(*bench.feed)) observe(*newest);
    return true;
  }
  if (!is_absent_for_good(bench)) return true;
  if (ended) ended(discovery_.loss_of(bench.number));
  return false;
}

/// A time in which this program did not run does not count.
bool StatusWatcher::is_absent_for_good(Bench& bench) const {
  const auto now = Clock::now() - discovery_.own_pauses();
  if (!bench.absent_since) bench.absent_since = now;
  return now - *bench.absent_since >= discovery_.patience();
}

void StatusWatcher::watch(const std::map<std::uint32_t, std::vector<std::uint16_t>>& axes,
                          std::chrono::milliseconds period, Observer observer, Ended ended) {
  std::vector<Bench> benches;
  for (const auto& [number, numbers] : axes) {
    Bench& bench = benches.emplace_back();
    bench.number = number;
    bench.axes = numbers;
  }
  thread_.start([this, period = std::max(period, kShortestPeriod), observe = std::move(observer),
                 ended = std::move(ended), benches = std::move(benches)]() mutable {
    std::erase_if(benches, [&](Bench& bench) {
      return !report(bench, observe, ended);
    });
    return benches.empty() ? kRest : period;
  });
}

}  // namespace vdrive::client
