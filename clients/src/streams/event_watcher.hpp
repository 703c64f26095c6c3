// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
#include "base/report_thread.hpp"
#include "presence/discovery.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive_messages.hpp"

#include <functional>
#include <stop_token>
#include <utility>

namespace vdrive::client {

/// Reports the events of benches to the program, in a thread of its own: the one that delivers must
/// not wait for a program that commands axes. Thread-safe.
class EventWatcher {
 public:
  /// @return the tick from which on events of a bench are new.
  using PresentTick = std::function<std::uint64_t(const PresentBench&)>;

  EventWatcher(wire::Participant& participant, const Discovery& discovery, ObserverFailure& failure,
               ReportThreads& threads, PresentTick present_tick)
      : participant_(participant),
        discovery_(discovery),
        failure_(failure),
        present_tick_(std::move(present_tick)),
        thread_(threads) {}

  /// Session::on_event.
  void watch(std::function<void(const Event&)> observer, EventHistory history);

 private:
  struct Watch;

  void on_event(Watch& watch, const msg::Event& message) const;
  void run(Watch& watch, const std::stop_token& stop,
           const std::function<void(const Event&)>& observe) const;
  bool meet(const BenchKey& key, Watch& watch, const std::stop_token& stop) const;

  wire::Participant& participant_;
  const Discovery& discovery_;
  ObserverFailure& failure_;
  PresentTick present_tick_;
  ReportThread thread_;
};

}  // namespace vdrive::client
