// SPDX-License-Identifier: Apache-2.0
#include "bus/tcp_acceptor.hpp"

#include "tcp_listen.hpp"

#include <chrono>
#include <utility>

namespace vdrive::canopen {
namespace {

// Without a pause, the thread would spin on accept() when the process has no file descriptors left.
constexpr std::chrono::milliseconds kAcceptPause{100};

}  // namespace

void turn_away(tcp::socket& socket, std::string_view words) {
  AsioError ignored;
  socket.non_blocking(true, ignored);
  socket.write_some(asio::buffer(words), ignored);
  socket.close(ignored);
}

struct TcpAcceptor::State final : std::enable_shared_from_this<TcpAcceptor::State> {
  State(asio::io_context& context, TcpAddress wanted, TcpServer& its_server)
      : acceptor(context), pause(context), address(std::move(wanted)), server(its_server) {
    bridge::listen_on(acceptor, address.host, address.port, address_text(address));
    address.port = acceptor.local_endpoint().port();
  }

  void accept() {
    acceptor.async_accept([self = shared_from_this()](const AsioError& error, tcp::socket socket) {
      if (!self->acceptor.is_open()) return;
      if (error) return self->accept_later();
      AsioError ignored;
      // Small writes do not wait for the acknowledgement of earlier ones.
      socket.set_option(tcp::no_delay(true), ignored);
      // Without keep-alive, a machine that was switched off would keep its place.
      socket.set_option(asio::socket_base::keep_alive(true), ignored);
      self->server.serve(std::move(socket));
      // That call may have closed the server.
      if (self->acceptor.is_open()) self->accept();
    });
  }

  /// After an error such as too many open files: the open connections continue.
  void accept_later() {
    pause.expires_after(kAcceptPause);
    pause.async_wait([self = shared_from_this()](const AsioError& error) {
      if (!error && self->acceptor.is_open()) self->accept();
    });
  }

  tcp::acceptor acceptor;
  asio::steady_timer pause;
  TcpAddress address;
  TcpServer& server;
};

TcpAcceptor::TcpAcceptor(asio::io_context& context, const TcpAddress& address, TcpServer& server)
    : state_(std::make_shared<State>(context, address, server)) {
  state_->accept();
}

TcpAcceptor::~TcpAcceptor() {
  close();
}

const TcpAddress& TcpAcceptor::address() const noexcept {
  return state_->address;
}

void TcpAcceptor::close() {
  AsioError ignored;
  state_->acceptor.close(ignored);
  cancel(state_->pause);
}

}  // namespace vdrive::canopen
