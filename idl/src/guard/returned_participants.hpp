// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rtps.hpp"

#include <chrono>
#include <cstddef>
#include <map>
#include <set>

namespace vdrive::wire {

/// Participants that were removed because they were silent, and that announce themselves again.
///
/// Such a participant may not have noticed anything: it was stopped, or the way here was cut. It
/// still counts as received what it sent before. The library begins with a writer that it matches
/// by an ACKNACK with number 0, after 70 ms; the writer then sends everything again. But after a
/// heartbeat that comes earlier it requests single samples, and the writer ignores a request for
/// what was acknowledged once (`ReaderProxy::acked_changes_set` and `requested_changes_set` of Fast
/// DDS 2.9.1; 3.1 begins by the same ACKNACK, `WriterProxy::perform_initial_ack_nack`). Then the
/// two do not find each other's endpoints any more. Therefore a heartbeat of a writer of such a
/// participant waits until the ACKNACK with number 0 for it has left.
///
/// Time is an argument. Not thread-safe.
class ReturnedParticipants {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::size_t kMostRemoved = 4'096;

  /// Nothing of a participant waits longer: a writer that no reader here matches gets no ACKNACK.
  static constexpr std::chrono::seconds kLongestWait{2};

  /// A participant was removed for its silence.
  void removed(const GuidPrefix& participant) {
    returned_.erase(participant);
    if (removed_.size() >= kMostRemoved) removed_.erase(removed_.begin());  // it may be any one
    removed_.insert(participant);
  }

  /// A participant announces itself.
  void announced(const GuidPrefix& participant, Clock::time_point now) {
    if (removed_.erase(participant) != 0) returned_[participant] = {.since = now, .greeted = {}};
  }

  /// A participant left by its own word: what comes with this prefix later is another one.
  void left(const GuidPrefix& participant) {
    removed_.erase(participant);
    returned_.erase(participant);
  }

  /// The ACKNACK with number 0 for this writer leaves.
  void greeted(const GuidPrefix& participant, EntityId writer) {
    const auto found = returned_.find(participant);
    if (found != returned_.end()) found->second.greeted.insert(writer);
  }

  /// @return whether a heartbeat of this writer has to wait.
  [[nodiscard]] bool holds_back(const GuidPrefix& participant, EntityId writer,
                                Clock::time_point now) const {
    const auto found = returned_.find(participant);
    return found != returned_.end() && now - found->second.since < kLongestWait &&
           !found->second.greeted.contains(writer);
  }

  /// Forgets those of whom nothing has to wait any more.
  void forget_old(Clock::time_point now) {
    std::erase_if(returned_, [now](const auto& each) {
      return now - each.second.since >= kLongestWait;
    });
  }

  /// @return whether nothing has to wait, of whomever.
  [[nodiscard]] bool empty() const noexcept { return returned_.empty(); }

 private:
  struct Returned {
    Clock::time_point since;
    std::set<EntityId> greeted;  ///< its writers
  };

  std::set<GuidPrefix> removed_;
  std::map<GuidPrefix, Returned> returned_;
};

}  // namespace vdrive::wire
