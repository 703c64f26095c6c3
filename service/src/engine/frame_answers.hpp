// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "base/counters.hpp"
#include "base/reason.hpp"
#include "base/ring.hpp"
#include "engine/answer_memory.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "seam/stored_replies.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>

namespace vdrive::service {

/// Sends the answers to command frames, and keeps the last ones for frames that arrive again.
class FrameAnswers {
 public:
  FrameAnswers(const BenchIdentity& identity, const BenchClock& clock, BenchEvents& events,
               Ring<StoredCommandReply>& queue, Counters& counters);

  /// @return whether the frame is addressed to this incarnation of the bench.
  [[nodiscard]] bool is_of_this_run(const msg::CommandFrame& frame) const noexcept;

  [[nodiscard]] Fate fate_of(const msg::CommandFrame& frame) const noexcept;

  /// Notes the arrival of a frame whose fate was unknown.
  void take(const msg::CommandFrame& frame);

  /// Resends the answer to a frame whose fate is `answered`.
  void repeat(const msg::CommandFrame& frame);

  /// Completes `reply`, keeps it and sends it.
  void send(const msg::CommandFrame& frame, msg::CommandReply& reply);

  /// Refuses the entire frame.
  void refuse(const msg::CommandFrame& frame, Reason reason);

 private:
  [[nodiscard]] std::uint64_t lateness(const msg::CommandFrame& frame) const noexcept;
  void post(const msg::CommandReply& reply);

  BenchIdentity identity_;
  const BenchClock& clock_;
  BenchEvents& events_;
  Ring<StoredCommandReply>& queue_;
  Counters& counters_;
  AnswerMemory<StoredCommandReply> memory_;  ///< by session and sequence number
  msg::CommandReply refusal_;                ///< of an entire frame
  msg::CommandReply repeated_;               ///< has room for the largest answer
};

}  // namespace vdrive::service
