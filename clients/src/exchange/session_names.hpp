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

/// Says who this session is, and learns who others are. A session that takes no axis has no writer,
/// and one that meets no other session no reader: each is made when it is needed first, and every
/// reader of a name pays for that once. What permissions do not allow, or DDS refuses, is left out:
/// then the others, or we, know no name. Thread-safe; the caller holds no lock of the session.
class SessionNames {
 public:
  using Clock = Discovery::Clock;

  /// For the match of a reader or a writer that is new: it takes milliseconds, and on a machine
  /// without a free processor longer.
  static constexpr std::chrono::milliseconds kMatchWait{1'000};
  /// For the samples of a bench that is matched.
  static constexpr std::chrono::milliseconds kFirstWait{250};
  /// For the name of a session that was not asked for before: it may have begun just now.
  static constexpr std::chrono::milliseconds kWait{100};

  /// @param program of this session, empty = the name of the file that this process runs
  SessionNames(wire::Participant& participant, std::uint64_t session, std::string program,
               const Discovery& discovery, Wakeup& wakeup);

  /// Says to a bench who this session is, once. The bench passes it on to who asks.
  void introduce(std::uint32_t bench);

  /// Waits until the benches have what was said, at most kMatchWait: a program that takes an axis
  /// and ends at once is gone before a bench has found its writer. To be called at the end of the
  /// session. An interrupt ends the wait between two benches.
  void finish();

  /// @return who a session is; nothing when it does not say. Waits for the match of a reader that
  /// is
  ///         new, for the first samples of the bench, and later for kWait. An interrupt ends the
  ///         wait.
  std::optional<SessionName> find(std::uint32_t bench, std::uint64_t session);

  /// @return the same without waiting; the first call begins to listen.
  std::optional<SessionName> known(std::uint32_t bench, std::uint64_t session);

  /// @return a refusal with the name of the session that stands in the way, where it has one; any
  ///         other outcome as it is.
  Outcome named(const Target& target, Outcome outcome);

 private:
  /// A place of the table that a bench keeps.
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
  const SessionName own_;  ///< as it is sent
  const Discovery& discovery_;
  Wakeup& wakeup_;

  std::mutex saying_;  ///< guards the next two; no other lock is taken with it
  std::set<std::uint32_t> introduced_;
  std::unique_ptr<wire::Publication<msg::SessionName>> publication_;

  mutable std::mutex mutex_;  ///< guards what was received and asked for
  std::map<Place, Known> names_;
  std::map<std::uint64_t, Clock::time_point> asked_;  ///< sessions, since when

  std::mutex listening_;  ///< guards what follows; not held where a name arrives
  Clock::time_point listens_since_{};
  std::map<std::uint32_t, Clock::time_point> matched_;  ///< benches, since when
  std::unique_ptr<wire::Subscription<msg::BenchSession>> subscription_;
};

}  // namespace vdrive::client
