// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/ascii_gateway.hpp"
#include "bus/bus.hpp"
#include "bus/tcp_address.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>

namespace boost::asio {
class io_context;
}

namespace vdrive::canopen {

/// The TCP port that the guides name; CiA 309-3 has none.
inline constexpr std::uint16_t kAsciiGatewayPort = 60'000;

struct AsciiGatewayServerSettings {
  TcpAddress listen{.host = "127.0.0.1", .port = kAsciiGatewayPort};
  GatewaySettings gateway{};
  std::size_t most_clients = 16;
};

/// What a server counts since it was made, where nothing else is stated.
struct AsciiGatewayCounters {
  std::size_t clients = 0;            ///< that are connected now
  std::uint64_t connections = 0;      ///< that were accepted
  std::uint64_t refused_clients = 0;  ///< beyond the most clients
  std::uint64_t commands = 0;         ///< lines that were answered
  std::uint64_t dropped_reports = 0;  ///< left out for clients that read too slowly
  std::uint64_t dropped_frames = 0;   ///< of the bus, more than were waited for
};

/// The gateway of CiA 309-3 for TCP clients, such as scripts and netcat: lines that end with CR LF
/// or LF, answers with CR LF. Lines of a client are carried out in their order; one that sends
/// faster than it is answered, or does not read, is not read meanwhile. A client that has sent all
/// gets the answers that are due before its connection is closed. For the thread of its context.
class AsciiGatewayServer final {
 public:
  /// A longer line is answered with a syntax error [bytes].
  static constexpr std::size_t kLongestLine = 4096;

  /// Listens on return, and serves while `context` runs.
  /// @param context, bus, host outlive the server
  /// @throws std::runtime_error when it cannot listen there, with the address and the reason
  AsciiGatewayServer(boost::asio::io_context& context, Bus& bus, BusHost& host,
                     const AsciiGatewayServerSettings& settings);

  /// Closes all connections.
  ~AsciiGatewayServer();
  AsciiGatewayServer(const AsciiGatewayServer&) = delete;
  AsciiGatewayServer& operator=(const AsciiGatewayServer&) = delete;

  /// @return where it listens, with the port that the system gave for 0.
  [[nodiscard]] const TcpAddress& address() const noexcept;

  [[nodiscard]] const AsciiGatewayCounters& counters() const noexcept;

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< an operation of the context that ends later keeps it
};

}  // namespace vdrive::canopen
