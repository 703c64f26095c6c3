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

/// Sends replies and command replies. The wire lets a reply wait up to 1 s until its client's
/// reader is known. Used by one thread.
class ReplyPublisher {
 public:
  /// Adds the page that an answer waits for.
  using Complete = std::function<void(OutgoingReply&)>;

  /// @param link outlives this
  ReplyPublisher(WireLink& link, const BenchIdentity& identity, Counters& counters,
                 Complete complete);

  /// Sends what waits in the outbox and answers what the inbox turned away. What finds no room in
  /// the lane of the wire stays in the outbox.
  /// @param most_pages how many pages may be computed: each may take some 100 ms, and the calling
  ///        thread has other work
  void deliver(Inbox& inbox, Outbox& outbox,
               std::size_t most_pages = std::numeric_limits<std::size_t>::max());

  /// @return whether the participant reads replies now.
  [[nodiscard]] bool is_matched(const wire::Source& source) const noexcept {
    return link_.is_matched(source);
  }

  /// @return whether a participant that read replies does so no more.
  [[nodiscard]] bool is_gone(const wire::Source& source) const noexcept {
    return link_.is_gone(source);
  }

  /// @return whether a reply waits for its reader and this thread has to check again.
  [[nodiscard]] bool is_waiting() const noexcept { return link_.is_holding(); }

 private:
  [[nodiscard]] bool refuse(const TurnedAway& arrival);

  WireLink& link_;
  BenchIdentity identity_;
  Counters& counters_;
  Complete complete_;
  msg::CommandReply command_reply_;  ///< the one that leaves
};

}  // namespace vdrive::service
