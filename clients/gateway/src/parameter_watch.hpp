// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "parameters.hpp"
#include "web_server.hpp"
#include "worker.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

namespace vdrive::gateway {

/// The parameters that clients have subscribed: reads them from time to time, and sends each client
/// those that have changed. Of the server's thread; the reading waits in a worker.
class ParameterWatch {
 public:
  /// Parameters that a connection may subscribe.
  static constexpr std::size_t kMost = 512;

  /// @param server outlives this, as `session` does
  ParameterWatch(WebServer& server, client::Session& session)
      : server_(server), session_(session) {}

  /// Subscribes, or ends subscriptions. @return false when there would be more than kMost; those
  /// before are subscribed.
  [[nodiscard]] bool subscribe(ConnectionId id, const SubscribeParameters& message);

  /// The connection is closed.
  void forget(ConnectionId id) { clients_.erase(id); }

  /// Reads what is subscribed, unless it is being read.
  void poll(const BenchList& benches);

 private:
  /// What one connection has subscribed.
  struct Subscribed {
    std::map<std::string, std::optional<std::int64_t>> values;  ///< as sent last
    std::set<std::string> unsent;                               ///< never sent
  };

  void on_polled(const ParameterAnswer& answer);

  WebServer& server_;
  client::Session& session_;
  std::map<ConnectionId, Subscribed> clients_;
  bool is_polling_ = false;
  bridge::Worker polls_;  ///< last: its job uses what is above
};

}  // namespace vdrive::gateway
