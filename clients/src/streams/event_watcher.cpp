// SPDX-License-Identifier: Apache-2.0
#include "streams/event_watcher.hpp"

#include "streams/event_filter.hpp"
#include "vdrive/wire/subscription.hpp"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>

namespace vdrive::client {
namespace {

// Events that wait for the program; of more the oldest are dropped.
constexpr std::size_t kMostWaiting = 4'096;

// The first sample of a bench, which has its tick, may come after its first event.
constexpr std::chrono::milliseconds kMeetPeriod{5};

Event event_of(const msg::Event& message) {
  return {.bench = message.bench(),
          .axis = message.axis(),
          .kind = static_cast<EventKind>(message.kind()),
          .tick = message.tick(),
          .session = message.session(),
          .code = message.code(),
          .error_register = message.error_register(),
          .suppressed = message.suppressed(),
          .text = message.text().to_string()};
}

}  // namespace

/// What one thread reports; it and the call that starts it own it.
struct EventWatcher::Watch {
  EventHistory history = EventHistory::left_out;
  EventFilter filter;  ///< of the thread
  std::mutex mutex;    ///< guards the queue
  std::deque<msg::Event> queue;
  std::condition_variable_any arrived;
  /// Declared last: its end waits for the handler, which uses the queue.
  std::unique_ptr<wire::Subscription<msg::Event>> subscription;
};

void EventWatcher::watch(std::function<void(const Event&)> observer, EventHistory history) {
  thread_.stop();  // ends the last watch
  if (!observer) return;
  const auto watch = std::make_shared<Watch>();
  watch->history = history;
  for (const PresentBench& bench : discovery_.present()) {
    watch->filter.begin(bench.key(), history == EventHistory::kept ? 0 : present_tick_(bench));
  }
  // Before the subscription, whose history arrives at once.
  thread_.start([this, watch, observe = std::move(observer)](const std::stop_token& stop) {
    failure_.run([&] {
      run(*watch, stop, observe);
    });
  });
  // Ends with this call, when the thread has not started or is over already.
  watch->subscription = std::make_unique<wire::Subscription<msg::Event>>(
      participant_,
      [this, its = watch.get()](const msg::Event& message, const wire::Source& /*source*/) {
        on_event(*its, message);
      });
}

void EventWatcher::on_event(Watch& watch, const msg::Event& message) const {
  if (!discovery_.sees(message.bench())) return;
  {
    const std::scoped_lock lock(watch.mutex);
    if (watch.queue.size() == kMostWaiting) watch.queue.pop_front();
    watch.queue.push_back(message);
  }
  watch.arrived.notify_all();
}

void EventWatcher::run(Watch& watch, const std::stop_token& stop,
                       const std::function<void(const Event&)>& observe) const {
  while (const auto message = next(watch, stop)) {
    const BenchKey key{message->bench(), message->incarnation()};
    if (!watch.filter.knows(key) && !meet(key, watch, stop)) continue;
    if (watch.filter.passes(*message)) observe(event_of(*message));
  }
}

/// @return the oldest event that waits; nothing when the watch ends.
std::optional<msg::Event> EventWatcher::next(Watch& watch, const std::stop_token& stop) {
  std::unique_lock lock(watch.mutex);
  const bool has_one = watch.arrived.wait(lock, stop, [&watch] {
    return !watch.queue.empty();
  });
  if (!has_one || stop.stop_requested()) return std::nullopt;
  msg::Event message = std::move(watch.queue.front());
  watch.queue.pop_front();
  return message;
}

/// Events of a bench that is met now begin at its present tick, which a sample of it has.
/// @return false when no sample comes: the run has ended.
bool EventWatcher::meet(const BenchKey& key, Watch& watch, const std::stop_token& stop) const {
  const auto deadline = Discovery::Clock::now() + kPresence;
  std::unique_lock lock(watch.mutex);
  while (!discovery_.is_alive(key, kPresence)) {
    if (stop.stop_requested() || Discovery::Clock::now() >= deadline) return false;
    (void)watch.arrived.wait_for(lock, stop, kMeetPeriod, [] {
      return false;
    });
  }
  watch.filter.begin(key, watch.history == EventHistory::kept ? 0 : discovery_.tick(key));
  return true;
}

}  // namespace vdrive::client
