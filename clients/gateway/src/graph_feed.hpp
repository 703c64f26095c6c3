// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "channel_table.hpp"
#include "client_table.hpp"
#include "hub_server.hpp"

#include <set>

namespace vdrive::gateway {

/// Sends the graph of connections to its subscribers: the topics and services, and who receives
/// them. Used in the server's thread.
class GraphFeed {
 public:
  /// @param server outlives this object, as do `channels` and `clients`
  GraphFeed(HubServer& server, ChannelTable& channels, const ClientTable& clients)
      : server_(server), channels_(channels), clients_(clients) {}

  /// Subscribes, and sends the graph immediately; or unsubscribes.
  void subscribe(ConnectionId id, bool is_on);

  /// The connection was closed.
  void forget(ConnectionId id) { subscribers_.erase(id); }

  /// Sends the graph to all subscribers if it has changed since the last call.
  void send_changes();

 private:
  void send(ConnectionId id) const;

  HubServer& server_;
  ChannelTable& channels_;
  const ClientTable& clients_;
  std::set<ConnectionId> subscribers_;
};

}  // namespace vdrive::gateway
