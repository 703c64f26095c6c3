// SPDX-License-Identifier: Apache-2.0
#include "metrics_endpoint.hpp"

// One thread runs the server: nothing to fence, and the thread sanitizer does not know fences.
#define BOOST_ASIO_DISABLE_FENCED_BLOCK
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <prometheus/text_serializer.h>

#include <chrono>
#include <string>
#include <thread>
#include <utility>

namespace vdrive::service {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using boost::asio::ip::tcp;

constexpr std::chrono::seconds kPatience{5};
constexpr std::uint32_t kLongestHead = 8'192;  // [bytes]
constexpr int kMostConnections = 16;

using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

Response answer(const Request& request, const Metrics& metrics) {
  Response response;
  response.version(request.version());
  response.keep_alive(false);
  response.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    response.result(http::status::method_not_allowed);
    response.set(http::field::allow, "GET, HEAD");
  } else if (request.target() != "/metrics") {
    response.result(http::status::not_found);
    response.body() = "the metrics are at /metrics\n";
  } else {
    response.body() = prometheus::TextSerializer().Serialize(metrics.Collect());
  }
  response.prepare_payload();
  if (request.method() == http::verb::head) {
    response.body().clear();
  }
  return response;
}

/// One connection: one request, one answer.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, const Metrics& metrics, int& open)
      : stream_(std::move(socket)), metrics_(metrics), open_(open) {
    ++open_;
    parser_.header_limit(kLongestHead);
  }

  ~Connection() { --open_; }

  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void run() {
    stream_.expires_after(kPatience);
    // The head says what is asked for; a body is of no use and is not read.
    http::async_read_header(stream_, buffer_, parser_,
                            [self = shared_from_this()](beast::error_code error, std::size_t) {
                              if (!error) {
                                self->reply();
                              }
                            });
  }

 private:
  void reply() {
    response_ = answer(parser_.get(), metrics_);
    http::async_write(stream_, response_,
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        self->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
                      });
  }

  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  Response response_;
  const Metrics& metrics_;
  int& open_;  ///< connections; all run in one thread
};

}  // namespace

class MetricsEndpoint::Server {
 public:
  Server(std::uint16_t port, std::unique_ptr<const Metrics> metrics)
      : metrics_(std::move(metrics)),
        acceptor_(context_, {boost::asio::ip::address_v4::loopback(), port}) {
    accept();
    thread_ = std::thread([this] {
      context_.run();
    });
  }

  ~Server() {
    context_.stop();
    thread_.join();
  }

  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  void accept() {
    acceptor_.async_accept([this](beast::error_code error, tcp::socket socket) {
      if (!error && open_ < kMostConnections) {
        std::make_shared<Connection>(std::move(socket), *metrics_, open_)->run();
      }
      accept();
    });
  }

  std::unique_ptr<const Metrics> metrics_;
  int open_ = 0;
  boost::asio::io_context context_{1};
  tcp::acceptor acceptor_;
  std::thread thread_;
};

MetricsEndpoint::MetricsEndpoint(std::uint16_t port, std::unique_ptr<const Metrics> metrics) {
  try {
    server_ = std::make_unique<Server>(port, std::move(metrics));
  } catch (const boost::system::system_error& error) {
    throw ConfigurationError("metrics.port = " + std::to_string(port) +
                             ": cannot listen there on 127.0.0.1: " + error.code().message());
  }
}

MetricsEndpoint::~MetricsEndpoint() = default;

std::uint16_t MetricsEndpoint::port() const {
  return server_->port();
}

}  // namespace vdrive::service
