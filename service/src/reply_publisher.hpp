// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "repeat_limiter.hpp"
#include "vdrive/service/bench_engine.hpp"
#include "vdrive/service/counters.hpp"
#include "vdrive/service/queues.hpp"
#include "vdrive/wire/publication.hpp"

#include <chrono>
#include <cstdint>
#include <deque>
#include <string_view>

namespace vdrive::service {

/// Sends replies and command replies. A reply waits up to 1 s until its client's reader is known;
/// meanwhile the others go on. Used by one thread.
class ReplyPublisher {
 public:
  static constexpr std::chrono::seconds kLongestWait{1};
  static constexpr std::size_t kMostWaiting = 256;

  ReplyPublisher(wire::Participant& participant, const BenchIdentity& identity, Counters& counters);

  /// Sends all that waits in the outbox, what the inbox turned away, and replies whose reader has
  /// been found since.
  void deliver(Inbox& inbox, Outbox& outbox);

  /// @return whether the participant reads replies now.
  [[nodiscard]] bool is_matched(const wire::Source& source) {
    return replies_.wait_for_match(source, std::chrono::milliseconds{0});
  }

  /// @return whether a reply waits for its reader.
  [[nodiscard]] bool is_waiting() const noexcept { return !waiting_.empty(); }

 private:
  using Clock = std::chrono::steady_clock;

  struct Waiting {
    OutgoingReply outgoing;
    Clock::time_point deadline;
  };

  void send(const OutgoingReply& outgoing);
  [[nodiscard]] bool try_send(const OutgoingReply& outgoing);
  void retry();
  void drop(const msg::Reply& reply, std::string_view why);
  void refuse(const TurnedAway& arrival);

  wire::Publication<msg::Reply> replies_;
  wire::Publication<msg::CommandReply> command_replies_;
  BenchIdentity identity_;
  Counters& counters_;
  std::deque<Waiting> waiting_;
  RepeatLimiter drop_log_;
};

}  // namespace vdrive::service
