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
#include "exchange/holdings.hpp"
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

/// What is behind a Session: its parts, each with the state that is its own. A part uses parts
/// above it only. Handlers of the wire fill the state and wake the calls that wait.
class SessionCore : public std::enable_shared_from_this<SessionCore> {
 public:
  /// @throws what Session throws
  explicit SessionCore(const SessionOptions& chosen);

  /// The session ends: gives all axes back, and no handle that is left sends anything. In a forked
  /// process nothing ends: the session is its parent's.
  void end();

  /// The session ends as if its program were killed: it sends nothing more and gives nothing back.
  void abandon() noexcept;

  /// Observes `axes` tick by tick.
  Follower follow(const Target& target, std::vector<std::uint16_t> axes, Pace pace);

  const SessionOptions options;
  const std::uint64_t id;  ///< of the session

  Wakeup wakeup;
  ObserverFailure failure{wakeup};
  ReportThreads reports;
  Holdings holdings;
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

/// @return the numbers of axes that share a bench; not_found where they do not, or there is none.
[[nodiscard]] Result<std::vector<std::uint16_t>> numbers_of(std::span<const AxisId> axes);

}  // namespace vdrive::client
