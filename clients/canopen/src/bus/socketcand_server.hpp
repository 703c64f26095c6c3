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
  /// Frames that wait for one client, at least 1: 0.3 s of the 50,000 frames/s of a bus that is
  /// flooded, 2 s of one of 1 Mbit/s.
  std::size_t most_waiting_frames = 16'384;
  /// A client for which that many wait holds the bus until half of them are sent, and loses none.
  bool holds_bus = false;
};

/// What a server counts since it was made, where nothing else is stated.
struct SocketcandCounters {
  std::size_t clients = 0;            ///< that are connected now
  std::uint64_t connections = 0;      ///< that were accepted
  std::uint64_t refused_clients = 0;  ///< beyond the most clients
  std::uint64_t received_frames = 0;  ///< that clients have put on the bus
  std::uint64_t sent_frames = 0;      ///< that were given to the kernel, for each client
  std::uint64_t dropped_frames = 0;   ///< left out for clients that read too slowly
  std::uint64_t refused_words = 0;    ///< that were answered with an error
};

/// A bus for clients of the socketcand protocol (bus/socketcand.hpp), each with its own port on it.
/// A client that goes is an unplugged cable; one that reads too slowly loses the oldest frames that
/// wait for it, and holds up nobody, unless the settings let it hold the bus. For the thread of its
/// context.
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

  /// @return where it listens, with the port that the system gave for 0.
  [[nodiscard]] const TcpAddress& address() const noexcept;

  [[nodiscard]] const SocketcandCounters& counters() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vdrive::canopen
