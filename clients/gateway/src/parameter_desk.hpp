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

/// Without names a client gets all parameters of benches that have so many axes together, or fewer.
inline constexpr std::size_t kMostAxesOfAll = 16;

/// @return the name of every object of every axis; none when these are more than kMostAxesOfAll.
[[nodiscard]] std::vector<std::string> all_parameters(const std::vector<KnownBench>& benches);

/// Reads parameters from their drives, those of an axis in one tick. Waits.
[[nodiscard]] ParameterAnswer read_parameters(client::Session& session,
                                              const std::vector<KnownBench>& benches,
                                              const std::vector<std::string>& names);

/// Writes parameters one after the other. Waits.
/// @return the values that the drives have then, and a complaint for each one that was refused.
[[nodiscard]] ParameterAnswer write_parameters(client::Session& session,
                                               const std::vector<KnownBench>& benches,
                                               const std::vector<ParameterChange>& changes);

/// The parameters that clients read, write and subscribe. What is asked for is read and written in
/// the thread of its connection; what is subscribed is read from time to time, and each client is
/// sent what has changed. Of the server's thread; the connections are open.
class ParameterDesk {
 public:
  /// Parameters that a connection may subscribe.
  static constexpr std::size_t kMost = 512;

  /// @param access outlives this, as the others do
  ParameterDesk(BenchAccess& access, HubServer& server, ClientTable& clients,
                const ControlDesk& control)
      : access_(access), server_(server), clients_(clients), control_(control) {}

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
  bridge::Worker polls_;  ///< last: its job uses what is above
};

}  // namespace vdrive::gateway
