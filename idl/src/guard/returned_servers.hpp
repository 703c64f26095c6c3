// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rtps.hpp"

#include <algorithm>
#include <cstdint>
#include <map>

namespace vdrive::wire {

/// Discovery servers that have been started again before the library gave up the former one.
///
/// A server has the same prefix after a restart, on another host, too. The library then takes it
/// for the one that it knows: its reader waits for numbers after those of the former server, and
/// its writers send nothing again that this one acknowledged (PDPClient of Fast DDS 2.9 and 3.1).
/// The two never find each other. Therefore nothing of a server that has begun to count its
/// heartbeats again reaches the library, until the library has given up the former one by its
/// lease.
///
/// Not thread-safe.
class ReturnedServers {
 public:
  /// Datagrams may overtake each other, and come by several interfaces.
  static constexpr std::uint32_t kMostOvertaken = 16;

  /// @param datagram that has passed check_datagram
  /// @return whether it comes from a server that the library has to give up first.
  [[nodiscard]] bool holds_back(ByteView datagram) {
    const GuidPrefix sender = sender_of(datagram);
    if (!is_server(sender)) return false;
    const auto known = servers_.find(sender);
    if (known != servers_.end() && known->second.has_returned) return true;
    Submessages submessages(datagram);
    for (Submessage submessage; !submessages.at_end() && submessages.next(submessage);) {
      if (submessage.kind != SubmessageKind::heartbeat) continue;
      ByteReader reader = submessage.reader();
      reader.skip(sizeof(EntityId));  // whom it is for
      constexpr std::size_t kTwoNumbers = 16;
      const bool is_of_participants = reader.entity() == kParticipantsWriter;
      reader.skip(kTwoNumbers);
      const std::uint32_t count = reader.u32();
      if (!is_of_participants || !reader.ok()) continue;
      Server& server = servers_[sender];
      const bool begins = count == 1 && server.count > 1;
      server.has_returned = begins || count + kMostOvertaken < server.count;
      if (server.has_returned) return true;
      server.count = std::max(server.count, count);
    }
    return false;
  }

  /// The library has given up a participant.
  void removed(const GuidPrefix& participant) { servers_.erase(participant); }

  /// @return whether the prefix is that of a server: both libraries begin it so
  ///         (get_server_client_default_guidPrefix, and fastdds discovery without an id).
  [[nodiscard]] static bool is_server(const GuidPrefix& participant) noexcept {
    return participant[0] == 'D' && participant[1] == 'S';
  }

 private:
  struct Server {
    std::uint32_t count = 0;  ///< of its heartbeats
    bool has_returned = false;
  };

  std::map<GuidPrefix, Server> servers_;
};

}  // namespace vdrive::wire
