// SPDX-License-Identifier: Apache-2.0
#include "streams/status_watcher.hpp"

#include "base/periodic_thread.hpp"
#include "presence/target.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace vdrive::client {
namespace {

using Clock = Discovery::Clock;

bool shows_the_same(const AxisSnapshot& one, const AxisSnapshot& other) {
  return one.id == other.id && one.owner_session == other.owner_session &&
         one.owner_epoch == other.owner_epoch && one.last_sequence == other.last_sequence &&
         std::ranges::all_of(status_members(), [&](const StatusMember& member) {
           return member.value(one.status) == member.value(other.status);
         });
}

}  // namespace

/// The axes of one bench.
struct StatusWatcher::Bench {
  BenchKey key;  ///< the run that is followed; incarnation 0 = none yet
  std::vector<std::uint16_t> axes;
  std::shared_ptr<StatusFeed> feed;  ///< none until the bench is there
  std::optional<Clock::time_point> absent_since;
  std::optional<Observation> shown;  ///< of this run
};

/// What one thread reports.
struct StatusWatcher::Watch {
  std::chrono::milliseconds period;
  Report report;
  Ended ended;
  std::vector<Bench> benches;
};

/// Follows the run of the service that is there now: a service that restarts is another run.
bool StatusWatcher::follow(Bench& bench, const Watch& watch, const std::stop_token& stop) const {
  if (const std::optional<Target> target = discovery_.continuation_of(bench.key)) {
    bench.absent_since.reset();
    if (!bench.feed || bench.key != target->key) {
      if (const auto first = begin(bench, *target)) show(bench, *first, watch.report);
    }
    if (stop.stop_requested()) return true;
    if (const auto newest = stream_.take_newest(*bench.feed)) show(bench, *newest, watch.report);
    return true;
  }
  if (!is_absent_for_good(bench)) return true;
  if (watch.ended) watch.ended(discovery_.loss_of(bench.key));
  return false;
}

/// A bench whose time stands repeats its state. It shows another one in the same tick when a
/// snapshot was restored or an axis has another owner.
void StatusWatcher::show(Bench& bench, const Observation& seen, const Report& report) {
  if (bench.shown && seen.tick < bench.shown->tick) return;
  if (bench.shown && seen.tick == bench.shown->tick &&
      std::ranges::equal(seen.axes, bench.shown->axes, shows_the_same)) {
    return;
  }
  bench.shown = seen;
  report(seen);
}

/// @return what the axes show now, in lock-step: while nobody steps no frame comes.
std::optional<Observation> StatusWatcher::begin(Bench& bench, const Target& target) const {
  bench.key = target.key;
  bench.shown.reset();
  bench.feed = stream_.open_feed(target, bench.axes);  // first: no tick is missed
  if (!target.steps()) return std::nullopt;
  auto shown = look_(target, bench.axes);
  if (!shown) return std::nullopt;
  return std::move(*shown);
}

bool StatusWatcher::is_absent_for_good(Bench& bench) const {
  const auto now = discovery_.running_time();
  if (!bench.absent_since) bench.absent_since = now;
  return now - *bench.absent_since >= discovery_.time_to_return();
}

void StatusWatcher::run(Watch& watch, const std::stop_token& stop) const {
  work_periodically(stop, [&]() -> std::optional<std::chrono::milliseconds> {
    const bool continues = failure_.run([&] {
      std::erase_if(watch.benches, [&](Bench& bench) {
        // A report may end its reports: none of another bench comes after it.
        return !stop.stop_requested() && !follow(bench, watch, stop);
      });
    });
    if (!continues || watch.benches.empty()) return std::nullopt;
    return watch.period;
  });
}

void StatusWatcher::watch(ReportThread& thread,
                          const std::map<std::uint32_t, std::vector<std::uint16_t>>& axes,
                          std::chrono::milliseconds period, Report report, Ended ended) const {
  std::vector<Bench> benches;
  for (const auto& [number, numbers] : axes) {
    Bench& bench = benches.emplace_back();
    bench.key.number = number;
    bench.axes = numbers;
  }
  thread.start(
      [this, watch = Watch{.period = period,
                           .report = std::move(report),
                           .ended = std::move(ended),
                           .benches = std::move(benches)}](const std::stop_token& stop) mutable {
        run(watch, stop);
      });
}

}  // namespace vdrive::client
