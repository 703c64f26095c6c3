// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "base/counters.hpp"
#include "seam/queues.hpp"
#include "seam/wire_link.hpp"
#include "vdrive_messages.hpp"

#include <cstddef>
#include <functional>
#include <limits>

namespace vdrive::service {

/// Sends replies and command replies. The wire holds a reply for up to 1 s until the reader of its
/// client is discovered. Used by one thread.
class ReplyPublisher {
 public:
  /// Computes the window page of an answer and adds it.
  using Complete = std::function<void(OutgoingReply&)>;

  /// @param link outlives this
  ReplyPublisher(WireLink& link, const BenchIdentity& identity, Counters& counters,
                 Complete complete);

  /// Sends the waiting answers of the outbox and answers what the inbox turned away. Answers that
  /// find no room in the lane of the wire stay in the outbox.
  /// @param most_pages the maximum number of pages to compute: each may take some 100 ms, and the
  ///        calling thread has other work
  void deliver(Inbox& inbox, Outbox& outbox,
               std::size_t most_pages = std::numeric_limits<std::size_t>::max());

  /// @return whether the participant is currently a reader of replies.
  [[nodiscard]] bool is_matched(const wire::Source& source) const noexcept {
    return link_.is_matched(source);
  }

  /// @return whether a participant that used to read replies is gone.
  [[nodiscard]] bool is_gone(const wire::Source& source) const noexcept {
    return link_.is_gone(source);
  }

  /// @return whether this thread has to call deliver() again soon, because a reply waits for its
  ///         reader.
  [[nodiscard]] bool is_waiting() const noexcept { return link_.is_holding(); }

 private:
  [[nodiscard]] bool refuse(const TurnedAway& arrival);

  WireLink& link_;
  BenchIdentity identity_;
  Counters& counters_;
  Complete complete_;
  msg::CommandReply command_reply_;  ///< the one being sent
};

}  // namespace vdrive::service
