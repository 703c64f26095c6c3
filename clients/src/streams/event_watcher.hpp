// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "presence/discovery.hpp"
#include "streams/event_filter.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.h"

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

namespace vdrive::client {

/// Reports the events of benches to the program, in a thread of its own: the thread of DDS must not
/// wait for a program that commands axes. Not thread-safe.
class EventWatcher {
 public:
  EventWatcher(wire::Participant& participant, const Discovery& discovery)
      : participant_(participant), discovery_(discovery) {}

  /// Session::on_event.
  void watch(std::function<void(const Event&)> observer, EventHistory history);

 private:
  void on_event(const msg::Event& message);
  void run(const std::stop_token& stop, EventFilter& filter,
           const std::function<void(const Event&)>& observe);
  [[nodiscard]] std::optional<msg::Event> next(const std::stop_token& stop);
  void begin(const BenchKey& key, EventFilter& filter) const;
  bool meet(const BenchKey& key, EventFilter& filter, const std::stop_token& stop);

  wire::Participant& participant_;
  const Discovery& discovery_;
  EventHistory history_ = EventHistory::left_out;  ///< changes while no watch runs
  std::mutex mutex_;                               ///< guards the queue
  std::deque<msg::Event> queue_;
  std::condition_variable_any arrived_;
  std::jthread thread_;
  std::unique_ptr<wire::Subscription<msg::Event>> subscription_;
};

}  // namespace vdrive::client
