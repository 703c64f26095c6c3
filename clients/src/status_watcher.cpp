// SPDX-License-Identifier: Apache-2.0
#include "status_watcher.hpp"

#include "target.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::client {
namespace {

constexpr std::chrono::milliseconds kShortestPeriod{1};

/// The axes of one bench.
struct WatchedBench {
  std::vector<std::uint16_t> axes;
  BenchKey key;
  std::shared_ptr<StatusFeed> feed;  ///< none until the bench is there
};

/// Follows the run of the service that is there now: a service that restarts is another run.
void follow_present_run(WatchedBench& watched, const PresentBench& bench, StatusStream& stream) {
  if (watched.feed && watched.key == bench.key()) return;
  watched.key = bench.key();
  watched.feed = stream.open_feed(target_of(bench), watched.axes);
}

}  // namespace

void StatusWatcher::watch(const std::map<std::uint32_t, std::vector<std::uint16_t>>& axes,
                          std::chrono::milliseconds period, Observer observer) {
  std::map<std::uint32_t, WatchedBench> benches;
  for (const auto& [bench, numbers] : axes) benches[bench].axes = numbers;
  thread_.start([this, period = std::max(period, kShortestPeriod), observe = std::move(observer),
                 benches = std::move(benches)]() mutable {
    for (const PresentBench& bench : discovery_.present()) {
      const auto found = benches.find(bench.info.number);
      if (found == benches.end()) continue;
      follow_present_run(found->second, bench, stream_);
      if (const auto newest = stream_.take_newest(*found->second.feed)) observe(*newest);
    }
    return period;
  });
}

}  // namespace vdrive::client
