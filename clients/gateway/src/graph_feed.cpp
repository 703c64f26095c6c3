// SPDX-License-Identifier: Apache-2.0
#include "graph_feed.hpp"

#include "services.hpp"

#include <string>

namespace vdrive::gateway {

void GraphFeed::subscribe(ConnectionId id, bool is_on) {
  if (!is_on) return forget(id);
  subscribers_.insert(id);
  send(id);
}

void GraphFeed::send_changes() {
  if (!channels_.take_change()) return;
  for (const ConnectionId id : subscribers_) send(id);
  channels_.forget_removed();
}

void GraphFeed::send(ConnectionId id) const {
  Graph graph;
  channels_.add_to(graph, clients_);
  for (const ServiceRow& row : services()) {
    graph.services.push_back({std::string(row.name), {"gateway"}});
  }
  server_.send_text(id, graph_text(graph));
}

}  // namespace vdrive::gateway
