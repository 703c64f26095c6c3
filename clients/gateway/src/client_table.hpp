// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hub_server.hpp"
#include "worker.hpp"

#include <atomic>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::gateway {

/// The open connections: their names, and a thread for each that carries out its calls. Used in the
/// server's thread. Functions require an open connection unless stated otherwise.
class ClientTable {
 public:
  void open(ConnectionId id);

  /// Drops calls that have not begun. @return whether the connection was open.
  bool close(ConnectionId id);

  [[nodiscard]] bool contains(ConnectionId id) const { return clients_.contains(id); }

  /// @return the open connections.
  [[nodiscard]] std::vector<ConnectionId> all() const;

  /// @return such as "client 7", or the name that the client has chosen.
  [[nodiscard]] const std::string& name(ConnectionId id) const;

  void rename(ConnectionId id, std::string name);

  /// Posts a job to the thread of the connection. @return false if too many are waiting.
  [[nodiscard]] bool post(ConnectionId id, std::function<void()> job);

  /// Destroys the threads of closed connections that have ended.
  void forget_ended();

  /// Waits for the threads of closed connections.
  void join_ended() { ended_.clear(); }

  /// The number of open connections. Thread-safe.
  [[nodiscard]] const std::atomic<std::size_t>& count() const noexcept { return count_; }

 private:
  struct Client {
    std::string name;
    std::unique_ptr<bridge::Worker> worker;
  };

  std::map<ConnectionId, Client> clients_;
  std::vector<std::unique_ptr<bridge::Worker>> ended_;
  std::atomic<std::size_t> count_ = 0;
};

}  // namespace vdrive::gateway
