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

}  // namespace

/// The axes of one bench.
struct StatusWatcher::Bench {
  std::uint32_t number = 0;
  std::vector<std::uint16_t> axes;
  BenchKey key;
  std::shared_ptr<StatusFeed> feed;  ///< none until the bench is there
  std::optional<Clock::time_point> absent_since;
  std::optional<std::uint64_t> shown_tick;  ///< of this run
};

/// Follows the run of the service that is there now: a service that restarts is another run.
bool StatusWatcher::follow(Bench& bench, const Report& report, const Ended& ended) const {
  const std::optional<Target> target = discovery_.present_target(bench.number);
  if (target) {
    bench.absent_since.reset();
    if (!bench.feed || bench.key != target->key) {
      if (const auto first = begin(bench, *target)) show(bench, *first, report);
    }
    if (const auto newest = stream_.take_newest(*bench.feed)) show(bench, *newest, report);
    return true;
  }
  if (!is_absent_for_good(bench)) return true;
  if (ended) ended(discovery_.loss_of(bench.number));
  return false;
}

/// A bench whose time stands repeats its state.
void StatusWatcher::show(Bench& bench, const Observation& seen, const Report& report) {
  if (bench.shown_tick && seen.tick <= *bench.shown_tick) return;
  bench.shown_tick = seen.tick;
  report(seen);
}

/// @return what the axes show now, in lock-step: while nobody steps no frame comes.
std::optional<Observation> StatusWatcher::begin(Bench& bench, const Target& target) const {
  bench.key = target.key;
  bench.shown_tick.reset();
  bench.feed = stream_.open_feed(target, bench.axes);  // first: no tick is missed
  if (!target.steps()) return std::nullopt;
  auto shown = look_(target, bench.axes);
  if (!shown) return std::nullopt;
  return std::move(*shown);
}

/// On a bus at once: who is there is a fact. Else a time in which this program did not run does not
/// count.
bool StatusWatcher::is_absent_for_good(Bench& bench) const {
  if (discovery_.is_on_bus()) return true;
  const auto now = Clock::now() - discovery_.own_pauses();
  if (!bench.absent_since) bench.absent_since = now;
  return now - *bench.absent_since >= discovery_.patience();
}

void StatusWatcher::watch(const std::map<std::uint32_t, std::vector<std::uint16_t>>& axes,
                          std::chrono::milliseconds period, Report report, Ended ended) {
  std::vector<Bench> benches;
  for (const auto& [number, numbers] : axes) {
    Bench& bench = benches.emplace_back();
    bench.number = number;
    bench.axes = numbers;
  }
  thread_.start(
      [this, period = std::max(period, kShortestPeriod), report = std::move(report),
       ended = std::move(ended),
       benches = std::move(benches)]() mutable -> std::optional<std::chrono::milliseconds> {
        const bool continues = failure_.run([&] {
          std::erase_if(benches, [&](Bench& bench) {
            return !follow(bench, report, ended);
          });
        });
        if (!continues || benches.empty()) return std::nullopt;
        return period;
      });
}

}  // namespace vdrive::client
