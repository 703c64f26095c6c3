// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/asio.hpp"
#include "bus/tcp_address.hpp"

#include <memory>
#include <string_view>

namespace vdrive::canopen {

/// What serves the connections that an acceptor accepts.
class TcpServer {
 public:
  virtual ~TcpServer() = default;

  /// @param socket sends at once what it is given, and notices that the machine of its peer is gone
  virtual void serve(tcp::socket&& socket) = 0;
};

/// Says to a peer, if it listens, why it is not served, and closes its connection.
void turn_away(tcp::socket& socket, std::string_view words);

/// Listens for TCP connections, and passes each to its server. For the thread of its context.
class TcpAcceptor final {
 public:
  /// Listens on return; connections are passed on while `context` runs.
  /// @param server is not called after close()
  /// @throws std::runtime_error when it cannot listen there, with the address and the reason
  TcpAcceptor(asio::io_context& context, const TcpAddress& address, TcpServer& server);

  /// As close().
  ~TcpAcceptor();
  TcpAcceptor(const TcpAcceptor&) = delete;
  TcpAcceptor& operator=(const TcpAcceptor&) = delete;

  /// @return where it listens, with the port that the system gave for 0.
  [[nodiscard]] const TcpAddress& address() const noexcept;

  /// Accepts no further connection.
  void close();

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< an operation of the context that ends later keeps it
};

}  // namespace vdrive::canopen
