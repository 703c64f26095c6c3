// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rtps.hpp"

#include <chrono>
#include <cstddef>
#include <cstring>
#include <unordered_map>
#include <vector>

namespace vdrive::wire {

/// Records when each participant last sent something and reports those that have been silent for
/// too long. Time is an argument. Not thread-safe.
/// @tparam Channel on which a participant announced itself
template <typename Channel>
class LeaseKeeper {
 public:
  using Clock = std::chrono::steady_clock;

  /// Limited because an attacker can announce any number of participants, and each takes memory.
  static constexpr std::size_t kMostParticipants = 4'096;

  struct Silent {
    GuidPrefix participant{};
    Channel channel{};
  };

  /// A participant has announced itself.
  /// @param patience how long it may be silent; Clock::duration::max() = forever
  /// @return whether there is room for it.
  [[nodiscard]] bool announced(const GuidPrefix& participant, Clock::duration patience,
                               Channel channel, Clock::time_point now) {
    const auto found = entries_.find(participant);
    if (found == entries_.end() && entries_.size() >= kMostParticipants) return false;
    // An expired participant must first be removed, even if it announces itself before that.
    if (found != entries_.end() && found->second.patience == Clock::duration{}) return true;
    entries_[participant] = {now, patience, channel};
    return true;
  }

  /// A datagram of a participant has arrived.
  void note_datagram(const GuidPrefix& participant, Clock::time_point now) {
    const auto found = entries_.find(participant);
    if (found != entries_.end()) found->second.last_datagram = now;
  }

  /// Makes the participant count as silent for too long from now on.
  void expire(const GuidPrefix& participant) {
    const auto found = entries_.find(participant);
    if (found != entries_.end()) {
      found->second.last_datagram = {};
      found->second.patience = {};
    }
  }

  void left(const GuidPrefix& participant) { entries_.erase(participant); }

  /// Forgets the participants that were announced on a channel that closes.
  void closed(Channel channel) {
    std::erase_if(entries_, [channel](const auto& entry) {
      return entry.second.channel == channel;
    });
  }

  /// @return those that have been silent for too long, and forgets them.
  [[nodiscard]] std::vector<Silent> take_silent(Clock::time_point now) {
    std::vector<Silent> silent;
    for (auto entry = entries_.begin(); entry != entries_.end();) {
      if (now - entry->second.last_datagram > entry->second.patience) {
        silent.push_back({entry->first, entry->second.channel});
        entry = entries_.erase(entry);
      } else {
        ++entry;
      }
    }
    return silent;
  }

  [[nodiscard]] std::size_t size() const { return entries_.size(); }

 private:
  struct Entry {
    Clock::time_point last_datagram;
    Clock::duration patience{};
    Channel channel{};
  };

  /// The last bytes of a prefix number participants and processes; the first bytes identify the
  /// vendor.
  struct Hash {
    std::size_t operator()(const GuidPrefix& prefix) const noexcept {
      std::uint64_t end = 0;
      std::uint32_t start = 0;
      std::memcpy(&end, prefix.data() + 4, sizeof end);
      std::memcpy(&start, prefix.data(), sizeof start);
      // 2^64 divided by the golden ratio: spreads neighbouring numbers far apart.
      constexpr std::uint64_t kOdd = 0x9E3779B97F4A7C15U;
      return static_cast<std::size_t>(((end ^ (end >> 29U)) + start) * kOdd >> 16U);
    }
  };

  std::unordered_map<GuidPrefix, Entry, Hash> entries_;
};

}  // namespace vdrive::wire
