// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_clocks.hpp"
#include "commands.hpp"
#include "connection.hpp"
#include "control.hpp"
#include "discovery.hpp"
#include "event_watcher.hpp"
#include "holdings.hpp"
#include "observer.hpp"
#include "requests.hpp"
#include "service_watcher.hpp"
#include "status_stream.hpp"
#include "status_watcher.hpp"
#include "unanswered.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/participant.hpp"
#include "waiter.hpp"
#include "wakeup.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace vdrive::client {

/// What is behind a Session: its parts, each with the state that is its own. A part uses parts
/// above it only. Handlers of DDS threads fill the state and wake the calls that wait.
class SessionCore : public std::enable_shared_from_this<SessionCore> {
 public:
  /// @throws what Session throws
  explicit SessionCore(const SessionOptions& chosen);

  /// The session ends: gives all axes back, and no handle that is left sends anything.
  void end();

  /// The session ends as if its program were killed: it sends nothing more and gives nothing back.
  void abandon() noexcept;

  /// Observes `axes` tick by tick.
  Follower follow(const Target& target, std::vector<std::uint16_t> axes, Pace pace);

  const SessionOptions options;
  const std::uint64_t id;  ///< of the session

  Wakeup wakeup;
  Holdings holdings;
  UnansweredMessages unanswered;
  wire::Participant participant;
  Discovery discovery;
  Connection connection;
  Waiter waiter;
  Requests requests;
  Commands commands;
  Control control;
  BenchClocks clocks;
  StatusStream stream;
  Observer observer;
  ServiceWatcher watcher;
  EventWatcher events;
  StatusWatcher statuses;
};

}  // namespace vdrive::client
