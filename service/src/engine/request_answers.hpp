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

/// Prepares, completes and sends the answers to requests, and keeps the last ones for requests that
/// arrive again.
class RequestAnswers {
 public:
  RequestAnswers(const BenchIdentity& identity, const BenchClock& clock, const BenchAxes& axes,
                 const Masters& masters, BenchEvents& events, Ring<OutgoingReply>& queue,
                 Counters& counters);

  /// @return whether the request is addressed to this incarnation of the bench, or to any.
  [[nodiscard]] bool is_of_this_run(const msg::Request& request) const noexcept;

  /// @return the number of the first axis in the request that the bench does not have.
  [[nodiscard]] std::optional<std::uint16_t> unknown_axis(const msg::Request& request) const;

  /// @return whether `open` has room for an answer.
  [[nodiscard]] bool has_room() const noexcept { return queue_.size() < queue_.capacity(); }

  /// @return the place of the next answer; nullptr if the queue is full, which is counted.
  [[nodiscard]] OutgoingReply* open();

  /// Fills the head of an answer, without results.
  void begin(const Arrival& arrival, OutgoingReply& outgoing) const;

  /// The meaning of the objects of an answer.
  enum class Objects : std::uint8_t {
    results,  ///< results for the objects in the request
    history,  ///< past events: a refusal among them does not concern this request
  };

  /// Completes an answer, counts and keeps it, and reports a refusal.
  void finish(std::uint64_t session, Reason reason, msg::Reply& reply,
              Objects objects = Objects::results);

  /// Sends the answer in the place that `open` returned.
  void push() noexcept { queue_.push(); }

  [[nodiscard]] Fate fate_of(const msg::Request& request) const noexcept;

  /// Notes the arrival of a request whose fate was unknown.
  void take(const msg::Request& request);

  /// Resends the answer to a request; refuses the request if the answer is no longer kept.
  void repeat(const Arrival& arrival);

  /// Adds the status of the axes in the request, all of which must exist.
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
