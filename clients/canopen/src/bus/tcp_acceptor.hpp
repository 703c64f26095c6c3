// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/asio.hpp"
#include "bus/tcp_address.hpp"

#include <memory>
#include <string_view>

namespace vdrive::canopen {

/// Serves the connections of an acceptor.
class TcpServer {
 public:
  virtual ~TcpServer() = default;

  /// @param socket has TCP_NODELAY and keep-alive set: it sends without delay, and notices when the
  ///        peer's machine is gone
  virtual void serve(tcp::socket&& socket) = 0;
};

/// Tells the peer, if it listens, why it is not served, and closes the connection.
void turn_away(tcp::socket& socket, std::string_view words);

/// Listens for TCP connections, and passes each to its server. For the thread of its context.
class TcpAcceptor final {
 public:
  /// Listens on return; passes on connections while `context` runs.
  /// @param server is not called after close()
  /// @throws std::runtime_error when it cannot listen there, with the address and the reason
  TcpAcceptor(asio::io_context& context, const TcpAddress& address, TcpServer& server);

  /// Calls close().
  ~TcpAcceptor();
  TcpAcceptor(const TcpAcceptor&) = delete;
  TcpAcceptor& operator=(const TcpAcceptor&) = delete;

  /// @return the address it listens on, with the actual port if 0 was requested.
  [[nodiscard]] const TcpAddress& address() const noexcept;

  /// Accepts no more connections.
  void close();

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< shared: pending operations of the context keep it alive
};

}  // namespace vdrive::canopen
