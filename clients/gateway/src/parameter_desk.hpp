// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client_table.hpp"
#include "control_desk.hpp"
#include "parameters.hpp"
#include "server_calls.hpp"
#include "worker.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace vdrive::gateway {

/// The parameters that clients read, write and subscribe. What is asked for is read and written in
/// the thread of its connection; what is subscribed is read from time to time, and each client is
/// sent what has changed. Of the server's thread; the connections are open.
class ParameterDesk {
 public:
  /// Parameters that a connection may subscribe.
  static constexpr std::size_t kMost = 512;

  /// How parameters are read and written. Both wait; any thread.
  struct Calls {
    std::function<ParameterAnswer(const BenchList& benches, const std::vector<std::string>& names)>
        read;
    /// @param own the session of the connection
    std::function<ParameterAnswer(const SessionPointer& own, const BenchList& benches,
                                  const std::vector<ParameterChange>& changes)>
        write;
  };

  /// @param clients outlives this, as `control` does
  ParameterDesk(Calls calls, ServerCalls server, ClientTable& clients, const ControlDesk& control);

  /// Without names: all, unless there are too many.
  void get(ConnectionId id, const GetParameters& message, const BenchList& benches);

  void set(ConnectionId id, const SetParameters& message, const BenchList& benches);

  /// Subscribes, or ends subscriptions; those beyond kMost are refused.
  void subscribe(ConnectionId id, const SubscribeParameters& message);

  /// The connection is closed.
  void forget(ConnectionId id) { subscribers_.erase(id); }

  /// Reads what is subscribed, unless it is being read.
  void poll(const BenchList& benches);

 private:
  /// What one connection has subscribed.
  struct Subscribed {
    std::map<std::string, std::optional<std::int64_t>> values;  ///< as sent last
    std::set<std::string> unsent;                               ///< never sent
  };

  void post(ConnectionId id, const std::optional<std::string>& request,
            std::function<ParameterAnswer()> call);
  void send(ConnectionId id, const ParameterAnswer& answer,
            const std::optional<std::string>& request) const;
  void on_polled(const ParameterAnswer& answer);

  const Calls calls_;
  const ServerCalls server_;
  ClientTable& clients_;
  const ControlDesk& control_;
  std::map<ConnectionId, Subscribed> subscribers_;
  bool is_polling_ = false;
  bridge::Worker polls_;  ///< last: its job uses what is above
};

}  // namespace vdrive::gateway
