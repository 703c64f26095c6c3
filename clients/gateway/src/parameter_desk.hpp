// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench_access.hpp"
#include "client_table.hpp"
#include "control_desk.hpp"
#include "hub_server.hpp"
#include "worker.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace vdrive::gateway {

/// The most axes, of all benches together, for which a request without names returns all
/// parameters.
inline constexpr std::size_t kMostAxesOfAll = 16;

/// @return the name of every object of every axis; none if there are more than kMostAxesOfAll axes.
[[nodiscard]] std::vector<std::string> all_parameters(const std::vector<KnownBench>& benches);

/// Reads parameters from their drives, those of an axis in one tick. Waits.
[[nodiscard]] ParameterAnswer read_parameters(client::Session& session,
                                              const std::vector<KnownBench>& benches,
                                              const std::vector<std::string>& names);

/// Writes parameters one after the other. Waits.
/// @return the values in the drives afterwards, and a complaint for each refused one.
[[nodiscard]] ParameterAnswer write_parameters(client::Session& session,
                                               const std::vector<KnownBench>& benches,
                                               const std::vector<ParameterChange>& changes);

/// The parameters that clients read, write and subscribe to. Reads and writes run in the thread of
/// the connection. Subscribed parameters are polled, and each client is sent the changed ones. Used
/// in the server's thread; functions require open connections.
class ParameterDesk {
 public:
  /// The most parameters to which a connection may subscribe.
  static constexpr std::size_t kMost = 512;

  /// @param access outlives this object, as do the other parameters
  ParameterDesk(BenchAccess& access, HubServer& server, ClientTable& clients,
                const ControlDesk& control)
      : access_(access), server_(server), clients_(clients), control_(control) {}

  /// Without names: all, unless there are too many.
  void get(ConnectionId id, const GetParameters& message, const BenchList& benches);

  void set(ConnectionId id, const SetParameters& message, const BenchList& benches);

  /// Subscribes or unsubscribes; subscriptions beyond kMost are refused.
  void subscribe(ConnectionId id, const SubscribeParameters& message);

  /// The connection was closed.
  void forget(ConnectionId id) { subscribers_.erase(id); }

  /// Reads the subscribed parameters, unless a read is in progress.
  void poll(const BenchList& benches);

 private:
  /// The subscriptions of one connection.
  struct Subscribed {
    std::map<std::string, std::optional<std::int64_t>> values;  ///< as last sent
    std::set<std::string> unsent;                               ///< never sent
  };

  template <typename Call>
  void post(ConnectionId id, const std::optional<std::string>& request, Call call);
  void send(ConnectionId id, const ParameterAnswer& answer,
            const std::optional<std::string>& request) const;
  void on_polled(const ParameterAnswer& answer);

  BenchAccess& access_;
  HubServer& server_;
  ClientTable& clients_;
  const ControlDesk& control_;
  std::map<ConnectionId, Subscribed> subscribers_;
  bool is_polling_ = false;
  bridge::Worker polls_;  ///< last: its job uses the members above
};

}  // namespace vdrive::gateway
