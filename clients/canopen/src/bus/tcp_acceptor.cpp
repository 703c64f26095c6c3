// SPDX-License-Identifier: Apache-2.0
#include "bus/tcp_acceptor.hpp"

#include "tcp_listen.hpp"

#include <chrono>
#include <utility>

namespace vdrive::canopen {
namespace {

// Without it a lack of file descriptors would keep the thread busy with accepting.
constexpr std::chrono::milliseconds kAcceptPause{100};

}  // namespace

struct TcpAcceptor::State final : std::enable_shared_from_this<TcpAcceptor::State> {
  State(asio::io_context& context, TcpAddress wanted, Accepted&& call)
      : acceptor(context), pause(context), address(std::move(wanted)), accepted(std::move(call)) {
    bridge::listen_on(acceptor, address.host, address.port, address_text(address));
    address.port = acceptor.local_endpoint().port();
  }

  void accept() {
    acceptor.async_accept([self = shared_from_this()](const AsioError& error, tcp::socket socket) {
      if (!self->acceptor.is_open()) return;
      if (error) return self->accept_later();
      self->accepted(std::move(socket));
      // The server may have been closed by that call.
      if (self->acceptor.is_open()) self->accept();
    });
  }

  /// Such as too many open files: the connections that are open continue.
  void accept_later() {
    pause.expires_after(kAcceptPause);
    pause.async_wait([self = shared_from_this()](const AsioError& error) {
      if (!error && self->acceptor.is_open()) self->accept();
    });
  }

  tcp::acceptor acceptor;
  asio::steady_timer pause;
  TcpAddress address;
  Accepted accepted;
};

TcpAcceptor::TcpAcceptor(asio::io_context& context, const TcpAddress& address, Accepted accepted)
    : state_(std::make_shared<State>(context, address, std::move(accepted))) {
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
