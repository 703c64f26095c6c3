// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/asio.hpp"
#include "bus/tcp_address.hpp"
#include "support/deadline.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::canopen {

/// Runs `context` until `condition` holds.
/// @param what names the condition in the report, such as "an answer"
/// @return false if the condition does not hold within 40 s, far more than it needs.
inline bool run_until(asio::io_context& context, std::string_view what,
                      const std::function<bool()>& condition) {
  constexpr std::chrono::seconds kPatience{40};
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= deadline) {
      test::report_missed_deadline(what, kPatience);
      return false;
    }
    context.restart();
    context.run_one_for(std::chrono::milliseconds(100));
  }
  return true;
}

/// A TCP client that shares its io_context with the server.
class TcpPeer final {
 public:
  /// Connects and starts to read.
  /// @throws boost::system::system_error if the connection fails
  TcpPeer(asio::io_context& context, const TcpAddress& address)
      : context_(context), state_(std::make_shared<State>(context)) {
    state_->socket.connect({asio::ip::make_address(address.host), address.port});
  }

  ~TcpPeer() { close(); }

  TcpPeer(const TcpPeer&) = delete;
  TcpPeer& operator=(const TcpPeer&) = delete;

  /// Reads until the connection ends, while the context runs.
  void read() { state_->read(); }

  void send(std::string_view text) { asio::write(state_->socket, asio::buffer(text)); }

  /// Shuts down the sending side; reading continues.
  void end_sending() { state_->socket.shutdown(tcp::socket::shutdown_send); }

  void close() {
    AsioError ignored;
    state_->socket.close(ignored);
  }

  /// Sends `text` and runs the context until the answering block has arrived.
  /// @return that block; empty if none arrived
  std::string ask(std::string_view text) {
    const std::size_t before = state_->blocks.size();
    send(text);
    return next_block(before);
  }

  /// @return block `number`, as received in one read; empty if it did not arrive.
  std::string next_block(std::size_t number) {
    const bool has_come = run_until(context_, "a block of bytes", [&] {
      return state_->blocks.size() > number || state_->has_ended;
    });
    return has_come && state_->blocks.size() > number ? state_->blocks[number] : std::string();
  }

  /// @return everything received.
  [[nodiscard]] std::string received() const {
    std::string all;
    for (const std::string& block : state_->blocks) all += block;
    return all;
  }

  [[nodiscard]] std::size_t received_bytes() const { return state_->bytes; }

  /// @return the number of frames received so far.
  [[nodiscard]] std::size_t received_frames() const { return state_->frames; }

  [[nodiscard]] std::size_t blocks() const { return state_->blocks.size(); }

  [[nodiscard]] bool has_ended() const { return state_->has_ended; }

 private:
  struct State final : std::enable_shared_from_this<State> {
    explicit State(asio::io_context& context) : socket(context) {}

    void read() {
      socket.async_read_some(asio::buffer(input), [self = this->shared_from_this()](
                                                      const AsioError& error, std::size_t size) {
        if (error) {
          self->has_ended = true;
          return;
        }
        self->blocks.emplace_back(self->input.data(), size);
        // Only frame words begin with a line feed.
        self->frames += static_cast<std::size_t>(std::ranges::count(self->blocks.back(), '\n'));
        self->bytes += size;
        self->read();
      });
    }

    tcp::socket socket;
    std::array<char, 65'536> input{};
    std::vector<std::string> blocks;
    std::size_t bytes = 0;
    std::size_t frames = 0;
    bool has_ended = false;
  };

  asio::io_context& context_;
  std::shared_ptr<State> state_;
};

}  // namespace vdrive::canopen
