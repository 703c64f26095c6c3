// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "presence/discovery.hpp"
#include "presence/target.hpp"
#include "vdrive/client/outcome.hpp"
#include "vdrive/client/session_name.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace vdrive::client {

/// Publishes the name of this session and receives the names of others. The writer is created when
/// the session acquires its first axis, the reader when it first asks for a name: only the call
/// that creates one waits for its match. If one of them is not permitted, or DDS refuses it, the
/// session does without: others do not learn its name, or it does not learn theirs. Thread-safe;
/// the caller must hold no lock of the session.
class SessionNames {
 public:
  using Clock = Discovery::Clock;

  /// Time for a new reader or writer to match: usually milliseconds, longer on a machine without a
  /// free processor.
  static constexpr std::chrono::milliseconds kMatchWait{1'000};
  /// Time for the samples of a bench to arrive after the match.
  static constexpr std::chrono::milliseconds kFirstWait{250};
  /// Time for the name of a session asked for the first time: it may have just started.
  static constexpr std::chrono::milliseconds kWait{100};

  /// @param program of this session; empty = the file name of this process's program
  SessionNames(wire::Participant& participant, std::uint64_t session, std::string program,
               const Discovery& discovery, Wakeup& wakeup);

  /// Sends the name of this session to a bench, once. The bench passes it on to those who ask.
  void introduce(std::uint32_t bench);

  /// Waits until the benches have received the name, at most kMatchWait: a program that acquires an
  /// axis and ends immediately would be gone before a bench has found its writer. Call this at the
  /// end of the session. An interrupt ends the wait before the next bench.
  void finish();

  /// @return the name of a session; nothing if it does not state one. Waits up to kMatchWait for a
  ///         new reader to match, then kFirstWait for the samples of the bench; later, kWait for a
  ///         session asked for the first time. An interrupt ends the wait.
  std::optional<SessionName> find(std::uint32_t bench, std::uint64_t session);

  /// @return as find(), without waiting; the first call starts listening.
  std::optional<SessionName> known(std::uint32_t bench, std::uint64_t session);

  /// @return a refusal with the name of the session that caused it, if it has one; any other
  ///         outcome unchanged.
  Outcome with_session_name(const Target& target, Outcome outcome);

 private:
  /// An entry in the table that a bench keeps.
  using Place = std::pair<std::uint32_t, std::uint16_t>;

  struct Known {
    std::uint64_t session = 0;
    SessionName name;
  };

  void listen();
  void on_name(const msg::BenchSession& message);
  [[nodiscard]] std::optional<SessionName> look_up(std::uint32_t bench,
                                                   std::uint64_t session) const;
  [[nodiscard]] std::optional<Clock::time_point> time_of_match(std::uint32_t bench);
  [[nodiscard]] Clock::time_point end_of_wait(std::uint32_t bench, std::uint64_t session);

  wire::Participant& participant_;
  const std::uint64_t session_;
  const SessionName own_;  ///< as sent
  const Discovery& discovery_;
  Wakeup& wakeup_;

  std::mutex saying_;  ///< guards the next two; taken before any other lock
  std::set<std::uint32_t> introduced_;
  std::unique_ptr<wire::Publication<msg::SessionName>> publication_;

  mutable std::mutex mutex_;  ///< guards the names received and the sessions asked for
  std::map<Place, Known> names_;
  std::map<std::uint64_t, Clock::time_point> asked_;  ///< when a session was first asked for

  std::mutex listening_;  ///< guards the members below; an arriving name does not take it
  Clock::time_point listens_since_{};
  std::map<std::uint32_t, Clock::time_point> matched_;  ///< benches, and since when
  std::unique_ptr<wire::Subscription<msg::BenchSession>> subscription_;
};

}  // namespace vdrive::client
