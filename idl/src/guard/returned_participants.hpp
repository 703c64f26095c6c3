// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rtps.hpp"

#include <chrono>
#include <cstddef>
#include <map>
#include <set>

namespace vdrive::wire {

/// Participants that were removed because they were silent and now announce themselves again.
///
/// Such a participant may not have noticed anything: it was suspended, or the network path was
/// interrupted. It still assumes that everything it sent earlier was received. 70 ms after the
/// library has matched a writer, it sends that writer an ACKNACK with number 0, and the writer then
/// sends everything again. But if a heartbeat arrives before that, the library requests individual
/// samples, and the writer ignores requests for samples that were once acknowledged
/// (`ReaderProxy::acked_changes_set` and `requested_changes_set` of Fast DDS 2.9.1; 3.1 starts with
/// the same ACKNACK, `WriterProxy::perform_initial_ack_nack`). The two then no longer find each
/// other's endpoints. So heartbeats of a writer of such a participant are held back until the
/// ACKNACK with number 0 has been sent to that writer.
///
/// Time is an argument. Not thread-safe.
class ReturnedParticipants {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::size_t kMostRemoved = 4'096;

  /// Upper limit of a wait: a writer that no reader here matches gets no ACKNACK.
  static constexpr std::chrono::seconds kLongestWait{2};

  /// A participant was removed because of its silence.
  void removed(const GuidPrefix& participant) {
    returned_.erase(participant);
    if (removed_.size() >= kMostRemoved) removed_.erase(removed_.begin());  // any one will do
    removed_.insert(participant);
  }

  /// A participant announces itself.
  void announced(const GuidPrefix& participant, Clock::time_point now) {
    if (removed_.erase(participant) != 0)
      returned_[participant] = {.since = now, .initial_acknack_sent = {}};
  }

  /// A participant announced that it left: a later one with this prefix is a different one.
  void left(const GuidPrefix& participant) {
    removed_.erase(participant);
    returned_.erase(participant);
  }

  /// The ACKNACK with number 0 for this writer is being sent.
  void initial_acknack_sent(const GuidPrefix& participant, EntityId writer) {
    const auto found = returned_.find(participant);
    if (found != returned_.end()) found->second.initial_acknack_sent.insert(writer);
  }

  /// @return whether a heartbeat of this writer must wait.
  [[nodiscard]] bool holds_back(const GuidPrefix& participant, EntityId writer,
                                Clock::time_point now) const {
    const auto found = returned_.find(participant);
    return found != returned_.end() && now - found->second.since < kLongestWait &&
           !found->second.initial_acknack_sent.contains(writer);
  }

  /// Forgets participants for which nothing needs to wait any more.
  void forget_old(Clock::time_point now) {
    std::erase_if(returned_, [now](const auto& each) {
      return now - each.second.since >= kLongestWait;
    });
  }

  /// @return whether nothing needs to wait for any participant.
  [[nodiscard]] bool empty() const noexcept { return returned_.empty(); }

 private:
  struct Returned {
    Clock::time_point since;
    std::set<EntityId> initial_acknack_sent;  ///< its writers
  };

  std::set<GuidPrefix> removed_;
  std::map<GuidPrefix, Returned> returned_;
};

}  // namespace vdrive::wire
