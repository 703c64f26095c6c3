// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/bounded_queue.hpp"

#include <boost/asio.hpp>

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

/// The protocol of the text bridge: lines over TCP. It knows nothing about benches.
namespace text_bridge {

namespace asio = boost::asio;
using asio::ip::tcp;
using AsioError = boost::system::error_code;

/// A client: its lines are executed one after another. Used on the thread of the loop only.
class Connection final : public std::enable_shared_from_this<Connection> {
 public:
  static constexpr std::size_t kLongestLine = 1'000;
  static constexpr std::size_t kMostWaitingLines = 256;

  using Obey = std::function<void(const std::string& line, std::shared_ptr<Connection>)>;

  Connection(tcp::socket&& socket, Obey obey)
      : socket_(std::move(socket)), obey_(std::move(obey)) {}

  [[nodiscard]] bool is_open() const { return socket_.is_open(); }

  /// Reads and executes the next line; sending its answer calls this again.
  void read() {
    const auto take_line = [self = shared_from_this()](const AsioError& error, std::size_t size) {
      if (error) return self->close();
      const std::string line = self->input_.substr(0, size);
      self->input_.erase(0, size);
      self->obey_(line, self);
    };
    asio::async_read_until(socket_, asio::dynamic_buffer(input_, kLongestLine), '\n', take_line);
  }

  void send(const std::string& line) {
    // Do not wait for a client that does not read.
    if (!output_.put(line + "\n")) return close();
    if (output_.size() == 1) write();
  }

 private:
  void write() {
    const auto& line = output_.items().front();
    asio::async_write(socket_, asio::buffer(line),
                      [self = shared_from_this()](const AsioError& error, std::size_t /*size*/) {
                        if (error) return self->close();
                        (void)self->output_.take();
                        if (!self->output_.empty()) self->write();
                      });
  }

  void close() {
    AsioError ignored;
    socket_.close(ignored);
  }

  tcp::socket socket_;
  const Obey obey_;
  std::string input_;
  vdrive::BoundedQueue<std::string> output_{kMostWaitingLines, vdrive::WhenFull::refuses_newest};
};

/// The answer to a line, sent by the destructor: even a job that is dropped with its bench is
/// answered. For any thread.
class Answer final {
 public:
  Answer(asio::io_context& loop, std::shared_ptr<Connection> connection)
      : loop_(loop), connection_(std::move(connection)) {}

  ~Answer() {
    asio::post(loop_, [connection = std::move(connection_), text = std::move(text_)] {
      connection->send(text);
      connection->read();
    });
  }

  Answer(const Answer&) = delete;
  Answer& operator=(const Answer&) = delete;

  void set(std::string text) {
    const std::scoped_lock lock(mutex_);
    text_ = std::move(text);
  }

  void fail(const std::string& problem) { set("error: " + problem); }

 private:
  asio::io_context& loop_;
  std::shared_ptr<Connection> connection_;
  std::mutex mutex_;
  std::string text_ = "error: the bench has gone";
};

}  // namespace text_bridge
