// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "base/counters.hpp"
#include "base/reason.hpp"
#include "engine/answer_memory.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "engine/masters.hpp"
#include "seam/queues.hpp"
#include "seam/stored_replies.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::service {

/// The answers to requests: begins, completes and sends them, and keeps the last ones for requests
/// that arrive again.
class RequestAnswers {
 public:
  RequestAnswers(const BenchIdentity& identity, const BenchClock& clock, const BenchAxes& axes,
                 const Masters& masters, BenchEvents& events, Ring<OutgoingReply>& queue,
                 Counters& counters);

  /// @return whether the request was sent to this run of the bench, or to any.
  [[nodiscard]] bool is_of_this_run(const msg::Request& request) const noexcept;

  /// @return the number of the first axis that the request names and the bench does not have.
  [[nodiscard]] std::optional<std::uint16_t> unknown_axis(const msg::Request& request) const;

  /// @return whether `open` has a place for an answer.
  [[nodiscard]] bool has_room() const noexcept { return queue_.size() < queue_.capacity(); }

  /// @return where the next answer goes, or nullptr when the queue is full, which is counted.
  [[nodiscard]] OutgoingReply* open();

  /// Fills the head of an answer, without results.
  void begin(const Arrival& arrival, OutgoingReply& outgoing) const;

  /// What the objects of an answer are.
  enum class Objects : std::uint8_t {
    results,  ///< what came of those that the request names
    history,  ///< what has happened before: a refusal among them is none of this request
  };

  /// Completes an answer, counts and keeps it, and reports a refusal.
  void finish(std::uint64_t session, Reason reason, msg::Reply& reply,
              Objects objects = Objects::results);

  /// Sends the answer that `open` gave the place of.
  void push() noexcept { queue_.push(); }

  [[nodiscard]] Fate fate_of(const msg::Request& request) const noexcept;

  /// The request, whose fate was unknown, has arrived.
  void take(const msg::Request& request);

  /// Answers a request that has been answered before.
  void repeat(const Arrival& arrival);

  /// Adds the status of the axes that the request names, all of which exist.
  void add_statuses(const msg::Request& request, OutgoingReply& outgoing) const;

 private:
  void keep(const msg::Reply& reply);

  BenchIdentity identity_;
  const BenchClock& clock_;
  const BenchAxes& axes_;
  const Masters& masters_;
  BenchEvents& events_;
  Ring<OutgoingReply>& queue_;
  Counters& counters_;
  AnswerMemory<StoredReply> memory_;  ///< by client and request id
};

}  // namespace vdrive::service
