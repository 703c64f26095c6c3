// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/asio.hpp"
#include "bus/tcp_address.hpp"

#include <functional>
#include <memory>

namespace vdrive::canopen {

/// Listens for TCP connections, and passes each to its server. For the thread of its context.
class TcpAcceptor final {
 public:
  using Accepted = std::function<void(tcp::socket&& socket)>;

  /// Listens on return; connections are passed on while `context` runs.
  /// @throws std::runtime_error when it cannot listen there, with the address and the reason
  TcpAcceptor(asio::io_context& context, const TcpAddress& address, Accepted accepted);

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
