// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/observer_failure.hpp"
#include "base/report_thread.hpp"
#include "base/wakeup.hpp"
#include "clocks/bench_clocks.hpp"
#include "clocks/observer.hpp"
#include "exchange/bench_links.hpp"
#include "exchange/command_history.hpp"
#include "exchange/control.hpp"
#include "exchange/exchange.hpp"
#include "exchange/held_axes.hpp"
#include "exchange/session_names.hpp"
#include "presence/discovery.hpp"
#include "session/watchers.hpp"
#include "streams/status_stream.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/participant.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace vdrive::client {

/// The implementation of a Session: its parts, each with its own state. A part uses only parts
/// declared above it. Handlers of the wire update the state and wake the calls that wait.
class SessionCore : public std::enable_shared_from_this<SessionCore> {
 public:
  /// @throws as Session does
  explicit SessionCore(const SessionOptions& chosen);

  /// Ends the session: releases all axes; remaining handles send nothing. In a forked process this
  /// does nothing, because the session belongs to the parent.
  void end();

  /// Ends the session as if its program had been killed: it sends nothing more and releases
  /// nothing.
  void abandon() noexcept;

  /// Observes `axes` tick by tick.
  Follower follow(const Target& target, std::vector<std::uint16_t> axes, Pace pace);

  const SessionOptions options;
  const std::uint64_t id;  ///< of the session

  Wakeup wakeup;
  ObserverFailure failure{wakeup};
  ReportThreads reports;
  HeldAxes held_axes;
  CommandHistory history;
  std::unique_ptr<wire::Participant> participant;
  Discovery discovery;
  SessionNames names;
  BenchLinks links;
  Exchange exchange;
  Control control;
  BenchClocks clocks;
  StatusStream stream;
  Observer observer;
  ServiceWatcher watcher;
  EventWatcher events;
  RefusalWatcher refusals;
  StatusWatcher statuses;
  ReportThread status_reports;  ///< of Session::on_status
};

/// @return the numbers of axes that share a bench; not_found if they do not, or if there are none.
[[nodiscard]] Result<std::vector<std::uint16_t>> numbers_of(std::span<const AxisId> axes);

}  // namespace vdrive::client
