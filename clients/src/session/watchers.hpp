// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
#include "base/report_thread.hpp"
#include "clocks/observer.hpp"
#include "exchange/bench_links.hpp"
#include "presence/discovery.hpp"
#include "streams/status_stream.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/event.hpp"
#include "vdrive/client/outcome.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

namespace vdrive::client {

// The reports of a session to the program, each on its own thread: the threads that deliver
// messages must not wait for a program that commands axes. All classes are thread-safe.

/// Changes in the presence of services: Session::watch_services.
class ServiceWatcher {
 public:
  ServiceWatcher(const Discovery& discovery, StatusStream& stream, ObserverFailure& failure,
                 ReportThreads& threads)
      : discovery_(discovery), stream_(stream), failure_(failure), thread_(threads) {}

  void watch(std::function<void(const ServiceChange&)> observer);

 private:
  const Discovery& discovery_;
  StatusStream& stream_;
  ObserverFailure& failure_;
  ReportThread thread_;
};

/// The events of benches: Session::on_event.
class EventWatcher {
 public:
  EventWatcher(wire::Participant& participant, const Discovery& discovery, Observer& observer,
               ObserverFailure& failure, ReportThreads& threads)
      : participant_(participant),
        discovery_(discovery),
        observer_(observer),
        failure_(failure),
        thread_(threads) {}

  void watch(std::function<void(const Event&)> observer, EventHistory history);

 private:
  struct Watch;

  void on_event(Watch& watch, const msg::Event& message) const;
  void run(Watch& watch, const std::stop_token& stop,
           const std::function<void(const Event&)>& observe) const;
  bool meet(const BenchKey& key, Watch& watch, const std::stop_token& stop) const;

  wire::Participant& participant_;
  const Discovery& discovery_;
  Observer& observer_;
  ObserverFailure& failure_;
  ReportThread thread_;
};

/// Refused values of set-points: Session::on_set_point_refusal.
class RefusalWatcher {
 public:
  RefusalWatcher(BenchLinks& links, ObserverFailure& failure, ReportThreads& threads);

  void watch(std::function<void(const SetPointRefusal&)> observer);

 private:
  struct Waiting;

  BenchLinks& links_;
  ObserverFailure& failure_;
  /// Shared by all watches: if two start at the same time, the remaining thread gets everything
  /// that arrives.
  std::shared_ptr<Waiting> waiting_;
  ReportThread thread_;
};

/// States of axes: Session::on_status, Session::report_status.
class StatusWatcher {
 public:
  using Report = std::function<void(const Observation&)>;
  using Ended = std::function<void(const Outcome&)>;

  StatusWatcher(const Discovery& discovery, StatusStream& stream, Observer& observer,
                ObserverFailure& failure)
      : discovery_(discovery), stream_(stream), observer_(observer), failure_(failure) {}

  /// Reports on this thread.
  /// @param axes by bench
  void watch(ReportThread& thread, const std::map<std::uint32_t, std::vector<std::uint16_t>>& axes,
             std::chrono::milliseconds period, Report report, Ended ended) const;

 private:
  struct Bench;
  struct Watch;

  void run(Watch& watch, const std::stop_token& stop) const;
  /// @return whether the reports of the bench continue.
  bool follow(Bench& bench, const Watch& watch, const std::stop_token& stop) const;
  static void show(Bench& bench, const Observation& seen, const Report& report);
  [[nodiscard]] std::optional<Observation> begin(Bench& bench, const Target& target) const;
  [[nodiscard]] bool is_absent_for_good(Bench& bench) const;

  const Discovery& discovery_;
  StatusStream& stream_;
  Observer& observer_;
  ObserverFailure& failure_;
};

}  // namespace vdrive::client
