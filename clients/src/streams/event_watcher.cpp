// SPDX-License-Identifier: Apache-2.0
#include "streams/event_watcher.hpp"

#include <chrono>
#include <cstddef>
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

void EventWatcher::watch(std::function<void(const Event&)> observer, EventHistory history) {
  subscription_.reset();  // no handler runs after this
  thread_.stop();         // ends the last watch
  {
    const std::scoped_lock lock(mutex_);
    queue_.clear();
  }
  if (!observer) return;
  history_ = history;
  EventFilter filter;
  for (const PresentBench& bench : discovery_.present()) {
    filter.begin(bench.key(), history == EventHistory::kept ? 0 : present_tick_(bench));
  }
  // Before the subscription, whose history arrives at once.
  thread_.start([this, filter = std::move(filter),
                 observe = std::move(observer)](const std::stop_token& stop) mutable {
    failure_.run([&] {
      run(stop, filter, observe);
    });
  });
  subscription_ = std::make_unique<wire::Subscription<msg::Event>>(
      participant_, [this](const msg::Event& message, const wire::Source& /*source*/) {
        on_event(message);
      });
}

void EventWatcher::on_event(const msg::Event& message) {
  if (!discovery_.sees(message.bench())) return;
  {
    const std::scoped_lock lock(mutex_);
    if (queue_.size() == kMostWaiting) queue_.pop_front();
    queue_.push_back(message);
  }
  arrived_.notify_all();
}

void EventWatcher::run(const std::stop_token& stop, EventFilter& filter,
                       const std::function<void(const Event&)>& observe) {
  while (const auto message = next(stop)) {
    const BenchKey key{message->bench(), message->incarnation()};
    if (!filter.knows(key) && !meet(key, filter, stop)) continue;
    if (filter.passes(*message)) observe(event_of(*message));
  }
}

/// @return the oldest event that waits; nothing when the watch ends.
std::optional<msg::Event> EventWatcher::next(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const bool has_one = arrived_.wait(lock, stop, [this] {
    return !queue_.empty();
  });
  if (!has_one || stop.stop_requested()) return std::nullopt;
  msg::Event message = std::move(queue_.front());
  queue_.pop_front();
  return message;
}

/// Events of a bench that is met now begin at its present tick, which a sample of it has.
/// @return false when no sample comes: the run has ended.
bool EventWatcher::meet(const BenchKey& key, EventFilter& filter, const std::stop_token& stop) {
  const auto deadline = Discovery::Clock::now() + kPresence;
  std::unique_lock lock(mutex_);
  while (!discovery_.is_alive(key, kPresence)) {
    if (stop.stop_requested() || Discovery::Clock::now() >= deadline) return false;
    (void)arrived_.wait_for(lock, stop, kMeetPeriod, [] {
      return false;
    });
  }
  filter.begin(key, history_ == EventHistory::kept ? 0 : discovery_.tick(key));
  return true;
}

}  // namespace vdrive::client
