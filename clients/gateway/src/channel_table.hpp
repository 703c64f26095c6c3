// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "channel.hpp"
#include "client_table.hpp"
#include "hub_server.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::gateway {

/// The topics of the gateway and its benches, with their receivers. Used in the server's thread
/// unless stated otherwise.
class ChannelTable {
 public:
  /// The most subscriptions of a connection: each costs memory, and the client chooses how many.
  static constexpr std::size_t kMostSubscriptions = 16'384;

  using Clock = std::chrono::steady_clock;

  /// Tools show the time from time messages; 20 per second look smooth.
  static constexpr std::chrono::milliseconds kTimePeriod{50};

  /// The bench number of the gateway's own topics. No bench has it.
  static constexpr std::uint32_t kOwn = 0;

  /// Why a subscription was refused; empty = it was not.
  using Problem = std::string;

  /// The most batches that may wait for the server's thread.
  static constexpr std::size_t kMostBatches = 256;

  /// @param server outlives this object
  explicit ChannelTable(HubServer& server) : server_(server) {}

  /// Sends the existing topics to a new connection.
  void open(ConnectionId id);

  /// The connection was closed.
  void close(ConnectionId id);

  /// Adds the topics of a bench, or of the gateway, and tells all connections.
  void add(std::uint32_t bench, const std::vector<ChannelPointer>& channels);

  void remove(std::uint32_t bench, const std::vector<ChannelPointer>& channels);

  /// @param subscribed set to the channel
  [[nodiscard]] Problem subscribe(ConnectionId id, const Subscription& wanted,
                                  ChannelPointer& subscribed);

  /// @return whether the connection has the most subscriptions allowed.
  [[nodiscard]] bool is_full(ConnectionId id) const {
    return connections_.at(id).size() >= kMostSubscriptions;
  }

  [[nodiscard]] Problem unsubscribe(ConnectionId id, std::uint32_t subscription);

  /// Posts publish() of a batch to the server's thread. When the server is late, new batches are
  /// dropped and counted, because late data are of no use. Thread-safe; does not wait.
  void put(Batch batch);

  /// @return the number of dropped batches. Thread-safe.
  [[nodiscard]] std::uint64_t lost_batches() const noexcept { return lost_batches_; }

  /// Sends a batch to the receivers of its topics. At most once per kTimePeriod, also sends all
  /// connections the time of the bench with the lowest number, which is the clock of tools.
  void publish(const Batch& batch, Clock::time_point now);

  /// @return whether topics or subscriptions have changed since the last call.
  [[nodiscard]] bool take_change() noexcept { return std::exchange(has_changed_, false); }

  /// Adds topics and subscriptions to the graph of connections.
  /// @param clients has the names of the connections
  void add_to(Graph& graph, const ClientTable& clients) const;

  /// Forgets removed topics, once clients have been told.
  void forget_removed() { removed_topics_.clear(); }

  [[nodiscard]] std::size_t size() const noexcept { return channels_.size(); }

  /// @return the number of topics that a client receives.
  [[nodiscard]] std::size_t subscribed() const;

  /// @return the number of subscriptions of all clients.
  [[nodiscard]] std::size_t subscriptions() const;

 private:
  using Subscriptions = std::map<std::uint32_t, ChannelPointer>;  ///< by the client's own number

  void send_time(const Batch& batch, Clock::time_point now);
  void end(ConnectionId id, std::uint32_t subscription, Channel& channel);
  void send_to_all(const SharedBytes& text);

  HubServer& server_;
  std::map<std::uint32_t, ChannelPointer> channels_;
  std::map<std::uint32_t, SharedBytes> advertisements_;  ///< by bench
  std::map<ConnectionId, Subscriptions> connections_;
  std::vector<std::string> removed_topics_;
  bool has_changed_ = false;
  Clock::time_point time_sent_{};
  std::atomic<std::size_t> batches_on_their_way_ = 0;
  std::atomic<std::uint64_t> lost_batches_ = 0;
};

}  // namespace vdrive::gateway
