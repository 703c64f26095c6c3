// SPDX-License-Identifier: Apache-2.0
#include "program/metrics_endpoint.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <prometheus/text_serializer.h>

#include <chrono>
#include <deque>
#include <string>
#include <thread>
#include <utility>

namespace vdrive::service {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using boost::asio::ip::tcp;

/// How long a connection is kept, whatever its client does.
constexpr std::chrono::seconds kPatience{5};
/// The pause after an error of accept, such as no free descriptor: without it the error would recur
/// immediately.
constexpr std::chrono::milliseconds kAcceptPause{100};
constexpr std::uint32_t kLongestHead = 8'192;  // [bytes]
constexpr std::size_t kMostConnections = 64;

using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

/// @return the requested path without its query, which has no meaning here.
beast::string_view path_of(const Request& request) {
  return request.target().substr(0, request.target().find('?'));
}

Response answer_to_probe(const std::function<ProbeAnswer()>& probe) {
  const ProbeAnswer answer = probe();
  Response response;
  response.result(answer.is_good ? http::status::ok : http::status::service_unavailable);
  response.body() = answer.text + "\n";
  return response;
}

Response page(beast::string_view path, const Metrics& metrics, const Probes& probes) {
  if (path == "/livez") return answer_to_probe(probes.is_alive);
  if (path == "/readyz") return answer_to_probe(probes.is_ready);
  Response response;
  if (path == "/metrics") {
    response.body() = prometheus::TextSerializer().Serialize(metrics.Collect());
  } else {
    response.result(http::status::not_found);
    response.body() = "not found; metrics: /metrics, probes: /livez and /readyz\n";
  }
  return response;
}

Response answer(const Request& request, const Metrics& metrics, const Probes& probes) {
  Response response;
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    response.result(http::status::method_not_allowed);
    response.set(http::field::allow, "GET, HEAD");
  } else {
    response = page(path_of(request), metrics, probes);
  }
  response.version(request.version());
  response.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
  return response;
}

Response bad_request(const beast::error_code& error) {
  Response response(http::status::bad_request, 11);  // HTTP/1.1
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.body() = "this is not a valid HTTP request: " + error.message() + "\n";
  return response;
}

/// One connection: one request, one answer.
class Scrape : public std::enable_shared_from_this<Scrape> {
 public:
  Scrape(tcp::socket socket, const Metrics& metrics, const Probes& probes)
      : stream_(std::move(socket)), metrics_(metrics), probes_(probes) {
    parser_.header_limit(kLongestHead);
  }

  void run() {
    stream_.expires_after(kPatience);
    // The head is enough; a body is not read.
    http::async_read_header(stream_, buffer_, parser_,
                            [self = shared_from_this()](beast::error_code error, std::size_t) {
                              self->reply_to(error);
                            });
  }

  /// Aborts the connection.
  void close() { stream_.close(); }

 private:
  void reply_to(const beast::error_code& error) {
    if (!error) {
      is_head_ = parser_.get().method() == http::verb::head;
      reply(answer(parser_.get(), metrics_, probes_));
    } else if (error.category() == make_error_code(http::error::bad_version).category() &&
               error != http::error::end_of_stream) {
      reply(bad_request(error));
    }  // else the client is gone, or has timed out
  }

  void reply(Response response) {
    response_ = std::move(response);
    response_.keep_alive(false);
    response_.prepare_payload();
    if (is_head_) response_.body().clear();
    http::async_write(stream_, response_,
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        if (!error) {
                          self->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
                          self->drain();
                        }
                      });
  }

  /// Reads and drops input until the client closes or times out: if a socket is closed with unread
  /// input, the kernel resets the connection, and the answer may be lost.
  void drain() {
    buffer_.clear();
    stream_.async_read_some(buffer_.prepare(kLongestHead),
                            [self = shared_from_this()](beast::error_code error, std::size_t) {
                              if (!error) self->drain();
                            });
  }

  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  Response response_;
  bool is_head_ = false;
  const Metrics& metrics_;
  const Probes& probes_;
};

}  // namespace

class MetricsEndpoint::Server {
 public:
  Server(const std::string& address, std::uint16_t port, std::unique_ptr<const Metrics> metrics,
         Probes probes)
      : metrics_(std::move(metrics)),
        probes_(std::move(probes)),
        acceptor_(context_, {boost::asio::ip::make_address_v4(address), port}) {
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
      if (error) {
        close_oldest();
        pause_.expires_after(kAcceptPause);
        pause_.async_wait([this](beast::error_code) {
          accept();
        });
        return;
      }
      serve(std::move(socket));
      accept();
    });
  }

  /// Serves every connection; if there are too many, closes the oldest. A scraper sends its request
  /// immediately, so the oldest is most likely idle.
  void serve(tcp::socket socket) {
    std::erase_if(connections_, [](const auto& connection) {
      return connection.expired();
    });
    if (connections_.size() >= kMostConnections) close_oldest();
    const auto connection = std::make_shared<Scrape>(std::move(socket), *metrics_, probes_);
    connections_.push_back(connection);
    connection->run();
  }

  void close_oldest() {
    if (connections_.empty()) return;
    if (const auto oldest = connections_.front().lock()) oldest->close();
    connections_.pop_front();
  }

  std::unique_ptr<const Metrics> metrics_;
  Probes probes_;
  std::deque<std::weak_ptr<Scrape>> connections_;  ///< the oldest first
  boost::asio::io_context context_{1};
  tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_{context_};
  std::thread thread_;
};

MetricsEndpoint::MetricsEndpoint(const std::string& address, std::uint16_t port,
                                 std::unique_ptr<const Metrics> metrics, Probes probes) {
  try {
    server_ = std::make_unique<Server>(address, port, std::move(metrics), std::move(probes));
  } catch (const boost::system::system_error& error) {
    throw ConfigurationError("metrics.port = " + std::to_string(port) +
                             ": cannot listen on this port of " + address + ": " +
                             error.code().message());
  }
}

MetricsEndpoint::~MetricsEndpoint() = default;

std::uint16_t MetricsEndpoint::port() const {
  return server_->port();
}

}  // namespace vdrive::service
