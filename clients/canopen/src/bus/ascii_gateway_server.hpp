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

/// The TCP port used in the guides; CiA 309-3 defines none.
inline constexpr std::uint16_t kAsciiGatewayPort = 60'000;

struct AsciiGatewayServerSettings {
  TcpAddress listen{.host = "127.0.0.1", .port = kAsciiGatewayPort};
  GatewaySettings gateway{};
  std::size_t most_clients = 16;
};

/// Counters of a server since its construction, unless noted otherwise.
struct AsciiGatewayCounters {
  std::size_t clients = 0;            ///< connected now
  std::uint64_t connections = 0;      ///< accepted
  std::uint64_t refused_clients = 0;  ///< beyond most_clients
  std::uint64_t commands = 0;         ///< lines answered
  std::uint64_t dropped_reports = 0;  ///< dropped for clients that read too slowly
  std::uint64_t dropped_frames = 0;   ///< frames of the bus beyond the size of the queue
};

/// The gateway of CiA 309-3 for TCP clients, such as scripts and netcat: lines end with CR LF or
/// LF, answers with CR LF. The lines of a client are carried out in order. The server stops reading
/// from a client that sends faster than it is answered, or that does not read its answers. A client
/// that has shut down its sending side still gets the pending answers before its connection is
/// closed. For the thread of its context.
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

  /// @return the address it listens on, with the actual port if 0 was requested.
  [[nodiscard]] const TcpAddress& address() const noexcept;

  [[nodiscard]] const AsciiGatewayCounters& counters() const noexcept;

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< shared: pending operations of the context keep it alive
};

}  // namespace vdrive::canopen
