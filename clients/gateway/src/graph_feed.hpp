// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "channel_table.hpp"
#include "client_table.hpp"
#include "server_calls.hpp"

#include <set>
#include <utility>

namespace vdrive::gateway {

/// Sends the graph of connections to the clients that have subscribed it: which topics and services
/// there are, and who receives them. Of the server's thread.
class GraphFeed {
 public:
  /// @param channels outlives this, as `clients` does
  GraphFeed(ServerCalls server, ChannelTable& channels, const ClientTable& clients)
      : server_(std::move(server)), channels_(channels), clients_(clients) {}

  /// Subscribes it, which sends it at once, or ends the subscription.
  void subscribe(ConnectionId id, bool is_on);

  /// The connection is closed.
  void forget(ConnectionId id) { subscribers_.erase(id); }

  /// Sends it to all subscribers when it has changed since the last call.
  void send_changes();

 private:
  void send(ConnectionId id) const;

  ServerCalls server_;
  ChannelTable& channels_;
  const ClientTable& clients_;
  std::set<ConnectionId> subscribers_;
};

}  // namespace vdrive::gateway
