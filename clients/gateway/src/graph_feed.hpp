// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "channel_table.hpp"
#include "client_table.hpp"
#include "hub_server.hpp"

#include <set>

namespace vdrive::gateway {

/// Sends the graph of connections to the clients that have subscribed it: which topics and services
/// there are, and who receives them. Of the server's thread.
class GraphFeed {
 public:
  /// @param server outlives this, as `channels` and `clients` do
  GraphFeed(HubServer& server, ChannelTable& channels, const ClientTable& clients)
      : server_(server), channels_(channels), clients_(clients) {}

  /// Subscribes it, which sends it at once, or ends the subscription.
  void subscribe(ConnectionId id, bool is_on);

  /// The connection is closed.
  void forget(ConnectionId id) { subscribers_.erase(id); }

  /// Sends it to all subscribers when it has changed since the last call.
  void send_changes();

 private:
  void send(ConnectionId id) const;

  HubServer& server_;
  ChannelTable& channels_;
  const ClientTable& clients_;
  std::set<ConnectionId> subscribers_;
};

}  // namespace vdrive::gateway
