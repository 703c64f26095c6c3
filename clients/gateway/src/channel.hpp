// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hub_server.hpp"
#include "protocol.hpp"

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdrive::gateway {

/// One subscription of one connection.
struct Receiver {
  ConnectionId connection = 0;
  std::uint32_t subscription = 0;
};

/// A topic. Its publisher checks whether a client receives it; everything else belongs to the hub.
struct Channel {
  explicit Channel(ChannelInfo described) : info(std::move(described)) {}

  const ChannelInfo info;
  std::atomic<std::uint32_t> subscriptions = 0;
  std::atomic<bool> has_new_receiver = false;  ///< a receiver waits for its first message
  std::vector<Receiver> receivers{};           ///< used by the hub's thread

  /// @return whether at least one client receives it.
  [[nodiscard]] bool is_wanted() const noexcept { return subscriptions != 0; }
};

using ChannelPointer = std::shared_ptr<Channel>;

/// A message for all receivers of a channel.
struct ChannelMessage {
  ChannelPointer channel;
  SharedBytes bytes;
};

/// The messages of a bench for one point in time.
struct Batch {
  std::uint32_t bench = 0;
  std::uint64_t time = 0;  ///< drive time [ns]
  std::vector<ChannelMessage> messages{};
};

/// @return the next number of a channel, unique in a run. Thread-safe.
[[nodiscard]] std::uint32_t next_channel_id();

}  // namespace vdrive::gateway
