// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rtps.hpp"
#include "vdrive/wire/guard.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace vdrive::wire {

/// @return a datagram in which a reader of `participant` acknowledges all numbers up to `base` - 1
///         of a writer here (RTPS 2.5, 9.4.5.2).
[[nodiscard]] inline std::vector<std::uint8_t> acknowledgement(const GuidPrefix& participant,
                                                               EntityId reader, EntityId writer,
                                                               std::int64_t base,
                                                               std::uint32_t count) {
  std::vector<std::uint8_t> datagram{'R', 'T', 'P', 'S', 2, 3, 1, 15};
  datagram.insert(datagram.end(), participant.begin(), participant.end());
  constexpr std::uint8_t kSize = 24;
  datagram.insert(datagram.end(), {0x06, 0x03, kSize, 0});  // ACKNACK, little endian, final
  const auto add = [&datagram](std::uint32_t number, bool little) {
    datagram.resize(datagram.size() + sizeof number);
    put_u32(std::span(datagram).last(sizeof number), number, little);
  };
  add(reader, false);
  add(writer, false);
  add(static_cast<std::uint32_t>(static_cast<std::uint64_t>(base) >> 32U), true);
  add(static_cast<std::uint32_t>(base), true);
  add(0, true);  // no bits: nothing is missing
  add(count, true);
  return datagram;
}

/// Readers of participants that no longer answer, for networks in which a discovery server reports
/// who has gone.
///
/// While no server answers, nobody reports that. A reliable writer then keeps the samples that the
/// readers of an ended participant never acknowledge, and once its history is full, it accepts no
/// sample for anybody. So once a participant has sent nothing for kPatienceWithVdrive, everything
/// is acknowledged on its behalf. In a network without a server, the guard removes a participant
/// after the same time, which frees the samples too.
///
/// Only participants that the library knows are followed, and not their built-in endpoints. Time is
/// an argument. Not thread-safe.
/// @tparam Channel on which a reader acknowledges
template <typename Channel>
class SilentReaders {
 public:
  using Clock = std::chrono::steady_clock;

  /// After a longer gap between two calls of take_due(), this program did not run, and the silence
  /// of others means nothing.
  static constexpr std::chrono::milliseconds kLongestPause{500};
  static constexpr std::size_t kMostReaders = 256;  ///< per participant

  struct Acknowledgement {
    Channel channel{};
    std::vector<std::uint8_t> datagram;
  };

  /// The library has found a participant.
  void found(const GuidPrefix& participant) { peers_.try_emplace(participant); }

  /// The library has given up a participant.
  void removed(const GuidPrefix& participant) { peers_.erase(participant); }

  /// A channel closes.
  void closed(Channel channel) {
    for (auto& [participant, peer] : peers_) {
      std::erase_if(peer.readers, [channel](const auto& reader) {
        return reader.second.channel == channel;
      });
    }
  }

  /// @param datagram one that has passed check_datagram; it arrived on `channel`
  void received(ByteView datagram, Channel channel) {
    const auto known = peers_.find(sender_of(datagram));
    if (known == peers_.end()) return;
    Peer& peer = known->second;
    peer.silent_since.reset();
    Submessages submessages(datagram);
    for (Submessage submessage; !submessages.at_end() && submessages.next(submessage);) {
      const auto acknack = parse_acknack(submessage);
      if (!acknack || is_built_in(acknack->writer)) continue;
      const std::pair key{acknack->reader, acknack->writer};
      if (peer.readers.size() >= kMostReaders && !peer.readers.contains(key)) continue;
      Reader& one = peer.readers[key];
      one = {
          .channel = channel, .base = std::max(acknack->base, one.base), .count = acknack->count};
    }
  }

  /// The library sends a datagram.
  void sends(ByteView datagram) {
    Submessages submessages(datagram);
    for (Submessage submessage; !submessages.at_end() && submessages.next(submessage);) {
      const auto heartbeat = parse_heartbeat(submessage);
      if (!heartbeat || is_built_in(heartbeat->writer)) continue;
      std::int64_t& highest = sent_[heartbeat->writer];
      highest = std::max(highest, heartbeat->last);
    }
  }

  /// Call a few times per second.
  /// @return the acknowledgements to pass to the library on behalf of silent participants.
  [[nodiscard]] std::vector<Acknowledgement> take_due(Clock::time_point now) {
    const bool has_paused = looked_ && now - *looked_ > kLongestPause;
    looked_ = now;
    std::vector<Acknowledgement> due;
    for (auto& [participant, peer] : peers_) {
      if (has_paused) peer.silent_since.reset();
      for (auto& [key, reader] : peer.readers) {
        const std::int64_t last = last_of(key.second);
        if (reader.base > last) continue;
        if (!peer.silent_since) peer.silent_since = now;
        if (now - *peer.silent_since < kPatienceWithVdrive) continue;
        due.push_back(acknowledged(participant, key, reader, last));
      }
    }
    return due;
  }

 private:
  struct Reader {
    Channel channel{};
    std::int64_t base = 1;  ///< the first number it has not acknowledged
    std::uint32_t count = 0;
  };

  struct Peer {
    std::map<std::pair<EntityId, EntityId>, Reader> readers{};  ///< by reader, and writer here
    std::optional<Clock::time_point> silent_since{};            ///< since when it owes an answer
  };

  /// @return the last number that this writer has sent; 0 if none.
  [[nodiscard]] std::int64_t last_of(EntityId writer) const {
    const auto sent = sent_.find(writer);
    return sent == sent_.end() ? 0 : sent->second;
  }

  [[nodiscard]] static Acknowledgement acknowledged(const GuidPrefix& participant,
                                                    const std::pair<EntityId, EntityId>& key,
                                                    Reader& reader, std::int64_t last) {
    reader.base = last + 1;
    ++reader.count;
    return {
        .channel = reader.channel,
        .datagram = acknowledgement(participant, key.first, key.second, reader.base, reader.count)};
  }

  std::map<GuidPrefix, Peer> peers_;
  std::map<EntityId, std::int64_t> sent_;  ///< the last number of each writer here
  std::optional<Clock::time_point> looked_;
};

}  // namespace vdrive::wire
