// SPDX-License-Identifier: Apache-2.0
#include "streams/event_watcher.hpp"

#include "base/report_queue.hpp"
#include "streams/event_filter.hpp"
#include "vdrive/wire/subscription.hpp"

#include <chrono>
#include <cstddef>
#include <memory>
#include <utility>

namespace vdrive::client {
namespace {

// Events that wait for the program; of more the oldest are dropped. There is room for all that a
// bench keeps.
constexpr std::size_t kMostWaiting = kEventKinds.size() * EventFilter::kRemembered + 4'096;

// The first sample of a bench, which has its tick, may come after its first event.
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

}  // namespace

/// What one thread reports; it and the call that starts it own it.
struct EventWatcher::Watch {
  EventHistory history = EventHistory::left_out;
  EventFilter filter;  ///< of the thread
  ReportQueue<msg::Event, kMostWaiting> queue;
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

/// Events of a bench that is met now begin at its present tick, which a sample of it has.
/// @return false when no sample comes: the run has ended.
bool EventWatcher::meet(const BenchKey& key, Watch& watch, const std::stop_token& stop) const {
  const auto deadline = Discovery::Clock::now() + kPresence;
  while (!discovery_.is_alive(key, kPresence)) {
    if (stop.stop_requested() || Discovery::Clock::now() >= deadline) return false;
    watch.queue.pause(stop, kMeetPeriod);
  }
  watch.filter.begin(key, watch.history == EventHistory::kept ? 0 : discovery_.tick(key));
  return true;
}

}  // namespace vdrive::client
