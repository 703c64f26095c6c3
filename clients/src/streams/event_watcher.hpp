// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
#include "base/periodic_thread.hpp"
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
#include <utility>

namespace vdrive::client {

/// Reports the events of benches to the program, in a thread of its own: the thread of DDS must not
/// wait for a program that commands axes. Not thread-safe.
class EventWatcher {
 public:
  /// @return the tick from which on events of a bench are new.
  using PresentTick = std::function<std::uint64_t(const PresentBench&)>;

  EventWatcher(wire::Participant& participant, const Discovery& discovery, ObserverFailure& failure,
               PresentTick present_tick)
      : participant_(participant),
        discovery_(discovery),
        failure_(failure),
        present_tick_(std::move(present_tick)) {}

  /// Session::on_event.
  void watch(std::function<void(const Event&)> observer, EventHistory history);

 private:
  void on_event(const msg::Event& message);
  void run(const std::stop_token& stop, EventFilter& filter,
           const std::function<void(const Event&)>& observe);
  [[nodiscard]] std::optional<msg::Event> next(const std::stop_token& stop);
  bool meet(const BenchKey& key, EventFilter& filter, const std::stop_token& stop);

  wire::Participant& participant_;
  const Discovery& discovery_;
  ObserverFailure& failure_;
  PresentTick present_tick_;
  EventHistory history_ = EventHistory::left_out;  ///< changes while no watch runs
  std::mutex mutex_;                               ///< guards the queue
  std::deque<msg::Event> queue_;
  std::condition_variable_any arrived_;
  ReportThread thread_;
  std::unique_ptr<wire::Subscription<msg::Event>> subscription_;
};

}  // namespace vdrive::client
