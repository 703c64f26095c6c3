// SPDX-License-Identifier: Apache-2.0
#include "session/watchers.hpp"

#include "base/periodic_thread.hpp"
#include "presence/target.hpp"
#include "streams/event_filter.hpp"
#include "vdrive/bounded_queue.hpp"
#include "vdrive/wire/subscription.hpp"

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <utility>

namespace vdrive::client {
namespace {

// Changes are reported within 100 ms: detecting silence takes 80 ms of that, see service_watch.cpp.
constexpr std::chrono::milliseconds kWatchPeriod{5};

// Maximum number of events waiting for the program; beyond it, the oldest are dropped. Enough for
// all events that a bench keeps and 4,096 more.
constexpr std::size_t kMostEvents = kEventKinds.size() * EventFilter::kRemembered + 4'096;

// The first sample of a bench, which contains its tick, may arrive after its first event.
constexpr std::chrono::milliseconds kMeetPeriod{5};

Event event_of(const msg::Event& message) {
  return {.bench = message.bench,
          .incarnation = message.incarnation,
          .axis = message.axis,
          .kind = static_cast<EventKind>(message.kind),
          .tick = message.tick,
          .session = message.session,
          .code = message.code,
          .error_register = message.error_register,
          .suppressed = message.suppressed,
          .text = message.text.to_string()};
}

// Room for 256 frames of 256 values each, because a program may count the refusals.
constexpr std::size_t kMostRefusals = 65'536;

using Clock = Discovery::Clock;

bool shows_the_same(const AxisSnapshot& one, const AxisSnapshot& other) {
  return one.id == other.id && one.owner_session == other.owner_session &&
         one.owner_epoch == other.owner_epoch && one.last_sequence == other.last_sequence &&
         std::ranges::all_of(status_members(), [&](const StatusMember& member) {
           return member.value(one.status) == member.value(other.status);
         });
}

}  // namespace

/// Items waiting for the thread that reports them to the program: a thread that delivers samples
/// adds them without waiting. Beyond `most`, the oldest are dropped. Thread-safe.
template <typename Item>
class ReportQueue {
 public:
  explicit ReportQueue(std::size_t most) : items_(most, WhenFull::drops_oldest) {}

  void put(Item item) {
    {
      const std::scoped_lock lock(mutex_);
      items_.put(std::move(item));
    }
    changed_.notify_all();
  }

  /// Waits for an item.
  /// @return the oldest; nothing once a stop is requested.
  std::optional<Item> next(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    const bool has_one = changed_.wait(lock, stop, [this] {
      return !items_.empty();
    });
    if (!has_one || stop.stop_requested()) return std::nullopt;
    return items_.take();
  }

  /// Drops the waiting items.
  void clear() {
    const std::scoped_lock lock(mutex_);
    items_.clear();
  }

  /// Waits for `period`, or until a stop is requested.
  void pause(const std::stop_token& stop, std::chrono::milliseconds period) {
    std::unique_lock lock(mutex_);
    static_cast<void>(changed_.wait_for(lock, stop, period, [] {
      return false;
    }));
  }

 private:
  std::mutex mutex_;
  BoundedQueue<Item> items_;
  std::condition_variable_any changed_;
};

// ---- services --------------------------------------------------------------------------------

void ServiceWatcher::watch(std::function<void(const ServiceChange&)> observer) {
  thread_.stop();
  if (!observer) return;
  stream_.subscribe();
  thread_.start([this, observe = std::move(observer),
                 watch = ServiceWatch()](const std::stop_token& stop) mutable {
    work_periodically(stop, [&]() -> std::optional<std::chrono::milliseconds> {
      const bool continues = failure_.run([&] {
        for (const ServiceChange& change : discovery_.changes(watch)) {
          if (stop.stop_requested()) return;
          observe(change);
        }
      });
      return continues ? std::optional(kWatchPeriod) : std::nullopt;
    });
  });
}

// ---- events ----------------------------------------------------------------------------------

/// The state of one reporting thread, owned by the thread and by the call that starts it.
struct EventWatcher::Watch {
  EventHistory history = EventHistory::left_out;
  EventFilter filter;  ///< used by the thread only
  ReportQueue<msg::Event> queue{kMostEvents};
  /// Declared last: its destructor waits for the handler, which uses the queue.
  std::unique_ptr<wire::Subscription<msg::Event>> subscription;
};

void EventWatcher::watch(std::function<void(const Event&)> observer, EventHistory history) {
  thread_.stop();  // ends the previous watch
  if (!observer) return;
  const auto watch = std::make_shared<Watch>();
  watch->history = history;
  for (const PresentBench& bench : discovery_.present()) {
    const std::uint16_t axis = bench.info.axes.front().id.axis;
    watch->filter.begin(bench.key(), history == EventHistory::kept
                                         ? 0
                                         : observer_.first_tick_of_stream(target_of(bench), axis));
  }
  // Started before the subscription, because the history of the subscription arrives immediately.
  thread_.start([this, watch, observe = std::move(observer)](const std::stop_token& stop) {
    failure_.run([&] {
      run(*watch, stop, observe);
    });
  });
  // If the thread has not started or has already ended, the subscription ends with this call.
  watch->subscription = std::make_unique<wire::Subscription<msg::Event>>(
      participant_,
      [this, its = watch.get()](const msg::Event& message, const wire::Source& /*source*/) {
        on_event(*its, message);
      });
}

void EventWatcher::on_event(Watch& watch, const msg::Event& message) const {
  if (discovery_.sees(message.bench)) watch.queue.put(message);
}

void EventWatcher::run(Watch& watch, const std::stop_token& stop,
                       const std::function<void(const Event&)>& observe) const {
  while (const auto message = watch.queue.next(stop)) {
    const BenchKey key{message->bench, message->incarnation};
    if (!watch.filter.knows(key) && !meet(key, watch, stop)) continue;
    if (watch.filter.passes(*message)) observe(event_of(*message));
  }
}

/// Waits for a sample of a newly found bench. The sample contains the present tick: unless the kept
/// events are wanted too, only events from then on are reported.
/// @return false if no sample arrives: the run has ended.
bool EventWatcher::meet(const BenchKey& key, Watch& watch, const std::stop_token& stop) const {
  const auto deadline = Discovery::Clock::now() + kPresence;
  while (!discovery_.is_alive(key, kPresence)) {
    if (stop.stop_requested() || Discovery::Clock::now() >= deadline) return false;
    watch.queue.pause(stop, kMeetPeriod);
  }
  watch.filter.begin(key, watch.history == EventHistory::kept ? 0 : discovery_.tick(key));
  return true;
}

// ---- refused values --------------------------------------------------------------------------

struct RefusalWatcher::Waiting {
  ReportQueue<SetPointRefusal> queue{kMostRefusals};
};

RefusalWatcher::RefusalWatcher(BenchLinks& links, ObserverFailure& failure, ReportThreads& threads)
    : links_(links), failure_(failure), waiting_(std::make_shared<Waiting>()), thread_(threads) {}

void RefusalWatcher::watch(std::function<void(const SetPointRefusal&)> observer) {
  links_.watch_refusals({});
  thread_.stop();  // ends the previous watch
  if (!observer) return;
  waiting_->queue.clear();
  thread_.start(
      [this, waiting = waiting_, observe = std::move(observer)](const std::stop_token& stop) {
        failure_.run([&] {
          while (const auto refusal = waiting->queue.next(stop)) observe(*refusal);
        });
      });
  // Must not capture `this`: the links outlive this object, and replies arrive until the links end.
  links_.watch_refusals([waiting = waiting_](const SetPointRefusal& refusal) {
    waiting->queue.put(refusal);
  });
}

// ---- status of axes --------------------------------------------------------------------------

/// The axes of one bench.
struct StatusWatcher::Bench {
  BenchKey key;  ///< the run being followed; incarnation 0 = none yet
  std::vector<std::uint16_t> axes;
  std::shared_ptr<StatusFeed> feed;  ///< none until the bench is present
  std::optional<Clock::time_point> absent_since;
  std::optional<Observation> shown;  ///< of this run
};

/// The state of one reporting thread.
struct StatusWatcher::Watch {
  std::chrono::milliseconds period;
  Report report;
  Ended ended;
  std::vector<Bench> benches;
};

/// Follows the present run of the service, which is another one after a restart.
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

/// A bench whose time stands still repeats its state. The state changes within the same tick only
/// if a snapshot was restored or an axis has another owner.
void StatusWatcher::show(Bench& bench, const Observation& seen, const Report& report) {
  if (bench.shown && seen.tick < bench.shown->tick) return;
  if (bench.shown && seen.tick == bench.shown->tick &&
      std::ranges::equal(seen.axes, bench.shown->axes, shows_the_same)) {
    return;
  }
  bench.shown = seen;
  report(seen);
}

/// @return in lock-step the present state of the axes, because no frame arrives until somebody
///         steps; otherwise nothing.
std::optional<Observation> StatusWatcher::begin(Bench& bench, const Target& target) const {
  bench.key = target.key;
  bench.shown.reset();
  bench.feed = stream_.open_feed(target, bench.axes);  // first, so that no tick is missed
  if (!target.steps()) return std::nullopt;
  auto shown = observer_.observe(target, bench.axes);
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
        // An observer may end its own reports: then no further bench is reported.
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
