// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/bus.hpp"
#include "bus/tcp_address.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>

namespace boost::asio {
class io_context;
}

namespace vdrive::canopen {

/// The TCP port of socketcand.
inline constexpr std::uint16_t kSocketcandPort = 29536;

struct SocketcandSettings {
  TcpAddress listen{.host = "127.0.0.1", .port = kSocketcandPort};
  std::size_t most_clients = 64;
  /// The queue size of one client in frames, at least 1: 0.3 s of a flooded bus (50,000 frames/s),
  /// 2 s at 1 Mbit/s.
  std::size_t most_waiting_frames = 16'384;
  /// A client whose queue is full holds the bus until half of it is sent, and loses no frame.
  bool holds_bus = false;
};

/// Counters of a server since its construction, unless noted otherwise.
struct SocketcandCounters {
  std::size_t clients = 0;            ///< connected now
  std::uint64_t connections = 0;      ///< accepted
  std::uint64_t refused_clients = 0;  ///< beyond most_clients
  std::uint64_t received_frames = 0;  ///< sent to the bus by clients
  std::uint64_t sent_frames = 0;      ///< handed to the kernel, counted for each client
  std::uint64_t dropped_frames = 0;   ///< dropped for clients that read too slowly
  std::uint64_t refused_words = 0;    ///< answered with an error
};

/// A bus for clients of the socketcand protocol (bus/socketcand.hpp), each with its own port on it.
/// A client that disconnects is like an unplugged cable. One that reads too slowly loses the oldest
/// frames of its queue and delays nobody else, unless the settings let it hold the bus. For the
/// thread of its context.
class SocketcandServer final {
 public:
  /// Listens on return, and serves while `context` runs.
  /// @param context, bus, host outlive the server
  /// @throws std::runtime_error when it cannot listen there, with the address and the reason
  SocketcandServer(boost::asio::io_context& context, Bus& bus, BusHost& host,
                   const SocketcandSettings& settings);

  /// Closes all connections.
  ~SocketcandServer();
  SocketcandServer(const SocketcandServer&) = delete;
  SocketcandServer& operator=(const SocketcandServer&) = delete;

  /// @return the address it listens on, with the actual port if 0 was requested.
  [[nodiscard]] const TcpAddress& address() const noexcept;

  [[nodiscard]] const SocketcandCounters& counters() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vdrive::canopen
