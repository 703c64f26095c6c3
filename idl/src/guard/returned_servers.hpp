// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rtps.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <utility>

namespace vdrive::wire {

/// Discovery servers that were restarted before the library had given up their previous run, which
/// is called the former server here.
///
/// A server has the same prefix after a restart, even on another host, so the library takes it for
/// the one that it knows: its reader waits for numbers after those of the former server, and its
/// writers do not resend what the former server acknowledged (PDPClient of Fast DDS 2.9 and 3.1).
/// The two would never find each other. So once the counts in a server's heartbeats or
/// acknowledgements start again, nothing from it reaches the library until the lease of the former
/// server has ended and the library has given it up.
///
/// Only servers that the library knows are followed, so that memory is bounded. Time is an
/// argument. Not thread-safe.
class ReturnedServers {
 public:
  using Clock = std::chrono::steady_clock;

  /// If a smaller count arrives this soon after a larger one, it has merely been overtaken:
  /// datagrams come through several interfaces and threads.
  static constexpr std::chrono::seconds kMostOvertaken{1};
  /// Upper limit of holding back, whatever lease the server announced: its counts may be forged.
  static constexpr std::chrono::seconds kLongestWait{30};

  /// The library has found a participant.
  void found(const GuidPrefix& participant) {
    if (is_server(participant)) servers_.try_emplace(participant);
  }

  /// The library has given up a participant.
  void removed(const GuidPrefix& participant) { servers_.erase(participant); }

  /// @param datagram that has passed check_datagram
  /// @return whether it comes from a server that the library must give up first.
  [[nodiscard]] bool holds_back(ByteView datagram, Clock::time_point now) {
    const auto known = servers_.find(sender_of(datagram));
    if (known == servers_.end()) return false;
    Server& server = known->second;
    if (server.has_returned && now - server.returned < kLongestWait) return true;
    if (server.has_returned) server = {};
    Submessages submessages(datagram);
    for (Submessage submessage; !submessages.at_end() && submessages.next(submessage);) {
      if (!begins_again(submessage, server, now)) continue;
      server.has_returned = true;
      server.returned = now;
      return true;
    }
    return false;
  }

  /// @return whether the prefix is that of a server: Fast DDS 2.9 and 3.1 start it this way
  ///         (get_server_client_default_guidPrefix, and fastdds discovery without an id).
  [[nodiscard]] static bool is_server(const GuidPrefix& participant) noexcept {
    return participant[0] == 'D' && participant[1] == 'S';
  }

 private:
  struct Count {
    std::uint32_t highest = 0;
    Clock::time_point since{};  ///< time at which it was received
  };

  struct Server {
    std::map<EntityId, Count> counts{};  ///< by discovery writer or reader of the server
    bool has_returned = false;
    Clock::time_point returned{};
  };

  [[nodiscard]] static bool begins_again(const Submessage& submessage, Server& server,
                                         Clock::time_point now) {
    const auto heartbeat = parse_heartbeat(submessage);
    const auto acknack = parse_acknack(submessage);
    if (!heartbeat && !acknack) return false;
    const EntityId sender = heartbeat ? heartbeat->writer : acknack->reader;
    const std::uint32_t number = heartbeat ? heartbeat->count : acknack->count;
    if (!is_of_discovery(sender)) return false;
    Count& count = server.counts[sender];
    if (number < count.highest) return now - count.since > kMostOvertaken;
    count = {.highest = number, .since = now};
    return false;
  }

  [[nodiscard]] static bool is_of_discovery(EntityId entity) noexcept {
    return entity == kParticipantsWriter || entity == kParticipantsReader ||
           entity == kPublicationsWriter || entity == kPublicationsReader ||
           entity == kSubscriptionsWriter || entity == kSubscriptionsReader;
  }

  std::map<GuidPrefix, Server> servers_;
};

}  // namespace vdrive::wire
