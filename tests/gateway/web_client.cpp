// SPDX-License-Identifier: Apache-2.0
#include "gateway/web_client.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <deque>
#include <stdexcept>
#include <utility>

namespace vdrive::test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;

tcp::endpoint endpoint(std::uint16_t port) {
  return {asio::ip::address_v4::loopback(), port};
}

}  // namespace

class WebClient::State {
 public:
  explicit State(const WebOptions& options) {
    auto& socket = stream_.next_layer();
    socket.open(tcp::v4());
    if (options.receive_buffer != 0) {
      socket.set_option(asio::socket_base::receive_buffer_size(options.receive_buffer));
    }
    socket.connect(endpoint(options.port));
    stream_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      if (!options.subprotocol.empty()) {
        request.set(beast::http::field::sec_websocket_protocol, options.subprotocol);
      }
      if (!options.origin.empty()) request.set(beast::http::field::origin, options.origin);
    }));
    websocket::response_type response;
    beast::error_code error;
    stream_.handshake(response, "127.0.0.1:" + std::to_string(options.port), options.target, error);
    if (error) throw std::runtime_error(error.message());
    subprotocol = std::string(response[beast::http::field::sec_websocket_protocol]);
    stream_.read_message_max(0);
    read();
  }

  void send(const std::string& bytes, bool is_text) {
    stream_.text(is_text);
    beast::error_code error;
    stream_.write(asio::buffer(bytes), error);
    if (error) has_ended = true;
  }

  void send_raw(const std::string& bytes) {
    beast::error_code ignored;
    asio::write(stream_.next_layer(), asio::buffer(bytes), ignored);
  }

  std::optional<WebMessage> receive(std::chrono::milliseconds patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (messages_.empty() && !has_ended) {
      const auto now = std::chrono::steady_clock::now();
      if (now >= deadline) return std::nullopt;
      context_.restart();
      context_.run_one_until(deadline);
    }
    if (messages_.empty()) return std::nullopt;
    WebMessage message = std::move(messages_.front());
    messages_.pop_front();
    return message;
  }

  void close() {
    stream_.async_close(websocket::close_code::normal, [this](beast::error_code) {
      has_ended = true;
    });
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (!has_ended && std::chrono::steady_clock::now() < deadline) {
      context_.restart();
      context_.run_one_until(deadline);
    }
  }

  std::string subprotocol;
  bool has_ended = false;

 private:
  void read() {
    stream_.async_read(buffer_, [this](beast::error_code error, std::size_t) {
      if (error) {
        has_ended = true;
        return;
      }
      messages_.push_back({stream_.got_text(), beast::buffers_to_string(buffer_.cdata())});
      buffer_.consume(buffer_.size());
      read();
    });
  }

  asio::io_context context_;
  websocket::stream<tcp::socket> stream_{context_};
  beast::flat_buffer buffer_;
  std::deque<WebMessage> messages_;
};

WebClient::WebClient(const WebOptions& options) : state_(std::make_unique<State>(options)) {}

WebClient::~WebClient() = default;

const std::string& WebClient::subprotocol() const noexcept {
  return state_->subprotocol;
}

void WebClient::send(const std::string& bytes, bool is_text) {
  state_->send(bytes, is_text);
}

void WebClient::send_raw(const std::string& bytes) {
  state_->send_raw(bytes);
}

std::optional<WebMessage> WebClient::receive(std::chrono::milliseconds patience) {
  return state_->receive(patience);
}

bool WebClient::has_ended() const noexcept {
  return state_->has_ended;
}

void WebClient::close() {
  state_->close();
}

class SilentConnection::State {
 public:
  explicit State(std::uint16_t port) { socket_.connect(endpoint(port)); }

 private:
  asio::io_context context_;
  tcp::socket socket_{context_};
};

SilentConnection::SilentConnection(std::uint16_t port) : state_(std::make_unique<State>(port)) {}

SilentConnection::~SilentConnection() = default;

std::string http_exchange(std::uint16_t port, const std::string& request) {
  asio::io_context context;
  tcp::socket socket(context);
  socket.connect(endpoint(port));
  asio::write(socket, asio::buffer(request));
  std::string answer;
  beast::error_code end;
  asio::read(socket, asio::dynamic_buffer(answer), end);
  return answer;
}

}  // namespace vdrive::test
