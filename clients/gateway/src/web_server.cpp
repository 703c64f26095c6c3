// SPDX-License-Identifier: Apache-2.0
#include "web_server.hpp"

#include "protocol.hpp"
#include "tcp_listen.hpp"
#include "vdrive/text.hpp"
#include "vdrive/token_bucket.hpp"
#include "vdrive/wording.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <map>
#include <stdexcept>
#include <utility>

namespace vdrive::gateway {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Clock = std::chrono::steady_clock;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

// A client sends its request and reads its answer immediately; a slower one only occupies a place.
constexpr std::chrono::seconds kHandshake{5};
// Without a pause, running out of file descriptors would keep the thread busy accepting.
constexpr std::chrono::milliseconds kAcceptPause{100};
// Short compared with the shortest patience with a client, 1 s.
constexpr std::chrono::milliseconds kWatchPeriod{250};
// A client that only receives data sends nothing but ping answers: several must fit into the usual
// patience.
constexpr std::chrono::milliseconds kPingPeriod{500};
// A turn polls the parameters of all clients together, twice a second at most. When a page is
// opened, it subscribes to a thousand topics; the subscriptions within one turn are sent as one
// change of the graph.
constexpr std::chrono::milliseconds kTurn{500};
// A report for each dropped message would add to what the client is too slow to read.
constexpr std::chrono::milliseconds kDropReport{1000};
// For the closing handshake: a client that is gone must not delay the end of the gateway.
constexpr std::chrono::milliseconds kCloseTime{1000};
constexpr std::size_t kLongestHead = 8192;          // [bytes] of an HTTP request
constexpr std::size_t kLongestMessage = 1U << 18U;  // [bytes] of a WebSocket message
// Kernel buffer: messages in it cannot be dropped any more, so a slow client sees them late.
constexpr int kSendBuffer = 1 << 18;                  // [bytes] in the kernel, which doubles it
constexpr std::ptrdiff_t kMostPlainConnections = 32;  // HTTP connections for each `Use`, in
                                                      // addition to the WebSockets

// Limits on the messages of a client. The burst allows a page to subscribe to a thousand axes.
constexpr TokenBucket::Rate kMessages{.per_second = 200.0, .burst = 4000.0};
constexpr TokenBucket::Rate kBytes{.per_second = 1e6, .burst = 4e6};

std::string_view view(boost::beast::string_view text) {
  return {text.data(), text.size()};
}

boost::beast::string_view beast_view(std::string_view text) {
  return {text.data(), text.size()};
}

/// @return how long the other machine has acknowledged nothing although data was sent; otherwise 0.
///         Its kernel acknowledges even if its program is late. If that program reads nothing and
///         its buffer is full, only few bytes are sent, and each is acknowledged.
std::chrono::milliseconds unacknowledged(tcp::socket& socket) {
  constexpr std::uint32_t kLongestRoundTrip = 200;  // [ms]
  tcp_info info{};
  socklen_t size = sizeof info;
  if (::getsockopt(socket.native_handle(), IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return {};
  const bool is_answered = info.tcpi_last_ack_recv <= info.tcpi_last_data_sent + kLongestRoundTrip;
  const bool is_under_way = info.tcpi_last_data_sent < kLongestRoundTrip;
  const bool has_all = info.tcpi_unacked == 0 || is_answered || is_under_way;
  return std::chrono::milliseconds(has_all ? 0 : info.tcpi_last_ack_recv);
}

/// @param text outlives the answer
PageAnswer text_answer(unsigned status, std::string_view text) {
  return {
      .status = status, .content_type = "text/plain", .cache_control = "no-store", .bytes = text};
}

/// The use of a connection.
enum class Use : std::uint8_t {
  clients,  ///< the page and WebSockets
  metrics,  ///< /metrics, for an operator's monitoring
};

/// State of the server that its connections use.
struct Shared {
  WebSettings settings;
  Page page;
  WebEvents* events = nullptr;  ///< set while the server runs
  WebCounters counters;
};

/// Codes that browsers and tools send when they leave; any other code indicates a failure.
bool is_farewell(std::uint16_t code) {
  return code == websocket::close_code::normal || code == websocket::close_code::going_away ||
         code == websocket::close_code::no_status || code == websocket::close_code::none;
}

/// Increments the counter of `kind`.
template <typename Counts, typename Kind>
void count(Counts& counts, Kind kind) {
  ++counts.at(static_cast<std::size_t>(kind));
}

/// One TCP connection: HTTP, which may become a WebSocket.
class WebConnection final : public std::enable_shared_from_this<WebConnection> {
 public:
  WebConnection(tcp::socket&& socket, Shared& shared, ConnectionId id, Use use)
      : shared_(shared), id_(id), use_(use), socket_(std::move(socket)) {}

  void start() { read_request(); }

  [[nodiscard]] bool is_over() const noexcept { return phase_ == Phase::over; }

  /// Whether it has this use and has not opened a WebSocket.
  [[nodiscard]] bool is_plain(Use use) const noexcept {
    return use_ == use && phase_ == Phase::http;
  }

  void push_data(Frame frame) {
    if (phase_ != Phase::open) return;
    shared_.counters.dropped += queue_.push_data(std::move(frame));
    write_next();
  }

  void push_answer(Frame frame, bool is_shared) {
    if (phase_ != Phase::open) return;
    // The client reads nothing. watch() closes the connection, because the caller may be iterating
    // over all connections.
    if (!queue_.push_answer(std::move(frame), is_shared)) is_overfull_ = true;
    write_next();
  }

  void set_patience(Patience patience) { patience_ = patience; }

  /// Pings, reports dropped messages, and closes lost connections. Called every kWatchPeriod.
  /// @param own_delay time in which this gateway itself did not run; does not count as silence of a
  ///        client
  void watch(Clock::time_point now, Clock::duration own_delay) {
    if (phase_ == Phase::closing && now >= close_deadline_) end(false);
    if (phase_ != Phase::open) return;
    // First, because messages that clients sent during the delay have not been read yet.
    received_ = std::min(now, received_ + own_delay);
    // A close frame would wait behind unread data.
    if (is_overfull_ || is_silent(now, own_delay)) {
      count(shared_.counters.cut_off, is_overfull_ ? CutOff::unread : CutOff::silent);
      return end(false);
    }
    if (now - pinged_ >= kPingPeriod) ping(now);
    if (now - reported_ >= kDropReport) report_dropped(now);
  }

  /// Reports the end of the server to the client.
  void announce_end() {
    has_announced_end_ = true;
    if (phase_ == Phase::open)
      close(websocket::close_code::going_away, "the gateway is shutting down");
    if (phase_ == Phase::http) end(false);
  }

  /// @param is_graceful see WebEvents::on_close()
  void end(bool is_graceful) {
    if (phase_ == Phase::over) return;
    const bool was_open = phase_ == Phase::open || phase_ == Phase::closing;
    phase_ = Phase::over;  // before the event, whose handler may send to this connection
    beast::error_code ignored;
    stream().socket().shutdown(tcp::socket::shutdown_both, ignored);
    stream().close();
    if (!was_open) return;
    --shared_.counters.clients;
    shared_.events->on_close(id_, is_graceful || has_announced_end_);
  }

 private:
  enum class Phase : std::uint8_t { http, open, closing, over };

  bool is_silent(Clock::time_point now, Clock::duration own_delay) {
    if (now - received_ > patience_.program) return true;
    // After its own delay, the gateway has just sent data that cannot be acknowledged yet.
    return own_delay == Clock::duration::zero() &&
           unacknowledged(stream().socket()) > patience_.machine;
  }

  beast::tcp_stream& stream() { return socket_.next_layer(); }

  // ---- HTTP

  void read_request() {
    parser_.emplace();
    parser_->header_limit(kLongestHead);
    parser_->body_limit(0);
    stream().expires_after(kHandshake);
    http::async_read(stream(), buffer_, *parser_,
                     beast::bind_front_handler(&WebConnection::on_request, shared_from_this()));
  }

  void on_request(beast::error_code error, std::size_t /*bytes*/) {
    if (error) return on_bad_request(error);
    const Request request = parser_->release();
    if (use_ == Use::metrics) return answer_metrics(request);
    if (websocket::is_upgrade(request)) return upgrade(request);
    if (!is_own_host(view(request[http::field::host]), shared_.settings.rules)) {
      return answer(request, text_answer(403, "This host is not a name of the gateway.\n"));
    }
    if (is_reading(request)) answer(request, find_page_file(shared_.page, view(request.target())));
  }

  /// The client is gone, its time has elapsed, or its data is not HTTP.
  void on_bad_request(beast::error_code error) {
    const bool is_gone = error == http::error::end_of_stream ||
                         error.category() != make_error_code(http::error::bad_version).category();
    if (is_gone) return end(false);
    Request unread;
    unread.version(11);  // HTTP/1.1
    unread.keep_alive(false);
    answer(unread,
           text_answer(400, "This is not a valid HTTP request: " + error.message() + ".\n"));
  }

  /// Whether the request only reads; otherwise answers it with an error.
  bool is_reading(const Request& request) {
    const bool reads = request.method() == http::verb::get || request.method() == http::verb::head;
    if (!reads) answer(request, text_answer(405, "GET and HEAD only.\n"));
    return reads;
  }

  void answer_metrics(const Request& request) {
    if (!is_reading(request)) return;
    const std::string_view target = view(request.target());
    if (target.substr(0, target.find('?')) != "/metrics") {
      return answer(request, text_answer(404, "The metrics are at /metrics.\n"));
    }
    const std::string metrics = shared_.events->metrics();
    answer(request, {.status = 200,
                     .content_type = "text/plain; version=0.0.4; charset=utf-8",
                     .cache_control = "no-store",
                     .bytes = metrics});
  }

  void answer(const Request& request, const PageAnswer& page) {
    response_ = Response(static_cast<http::status>(page.status), request.version());
    response_.set(http::field::server, "vdrive-gateway");
    response_.set(http::field::content_type, beast_view(page.content_type));
    response_.set(http::field::cache_control, beast_view(page.cache_control));
    response_.set("Content-Security-Policy", beast_view(kContentSecurityPolicy));
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");
    // Scrapers get one answer per connection, as from the metrics of the service.
    response_.keep_alive(use_ == Use::clients && request.keep_alive());
    response_.content_length(page.bytes.size());
    if (request.method() != http::verb::head) response_.body() = page.bytes;
    stream().expires_after(kHandshake);
    http::async_write(stream(), response_,
                      beast::bind_front_handler(&WebConnection::on_answered, shared_from_this()));
  }

  void on_answered(beast::error_code error, std::size_t /*bytes*/) {
    if (error || !response_.keep_alive()) return end(false);
    read_request();
  }

  // ---- WebSocket

  void upgrade(const Request& request) {
    Admission admission = admit({.target = view(request.target()),
                                 .host = view(request[http::field::host]),
                                 .origin = view(request[http::field::origin]),
                                 .protocols = view(request[http::field::sec_websocket_protocol]),
                                 .authorization = view(request[http::field::authorization])},
                                shared_.settings.rules);
    const std::size_t clients = shared_.counters.clients;
    if (admission.status == 101 && clients >= shared_.settings.most_clients) {
      admission.status = 503;
      admission.refusal = Refusal::clients;
      admission.reason = counted(clients, "client is", "clients are") +
                         " connected, which is as many as --clients allows";
    }
    if (admission.status != 101) {
      count(shared_.counters.refused, admission.refusal);
      Request last = request;  // a refused connection has no further use
      last.keep_alive(false);
      return answer(last, text_answer(admission.status, admission.reason + "\n"));
    }
    accept(request, admission.subprotocol);
  }

  void accept(const Request& request, const std::string& subprotocol) {
    stream().expires_never();
    websocket::stream_base::timeout times{};
    times.handshake_timeout = kHandshake;
    // Beast's own time-out is off, because it would count a delay of this gateway as the client's:
    // watch() decides.
    times.idle_timeout = websocket::stream_base::none();
    times.keep_alive_pings = false;
    socket_.set_option(times);
    socket_.set_option(
        websocket::stream_base::decorator([subprotocol](websocket::response_type& response) {
          response.set(http::field::server, "vdrive-gateway");
          response.set(http::field::sec_websocket_protocol, subprotocol);
        }));
    socket_.read_message_max(kLongestMessage);
    // One frame per message, so that nothing is copied on the way to the kernel.
    socket_.auto_fragment(false);
    socket_.control_callback([this](websocket::frame_type, beast::string_view) {
      received_ = Clock::now();
    });
    // A client must wait for the answer: data sent together with its request is not read as a
    // message.
    buffer_.consume(buffer_.size());
    socket_.async_accept(request,
                         beast::bind_front_handler(&WebConnection::on_accept, shared_from_this()));
  }

  void on_accept(beast::error_code error) {
    if (phase_ != Phase::http) return;
    if (error) return end(false);
    phase_ = Phase::open;
    ++shared_.counters.clients;
    ++shared_.counters.connections;
    received_ = Clock::now();
    shared_.events->on_open(id_);
    read_message();
  }

  void read_message() {
    if (phase_ == Phase::over) return;
    socket_.async_read(buffer_,
                       beast::bind_front_handler(&WebConnection::on_message, shared_from_this()));
  }

  void on_message(beast::error_code error, std::size_t /*bytes*/) {
    if (error) return end(error == websocket::error::closed && is_farewell(socket_.reason().code));
    received_ = Clock::now();
    const auto bytes = buffer_.cdata();
    messages_.refill(received_.time_since_epoch());
    bytes_.refill(received_.time_since_epoch());
    if (!messages_.take() || !bytes_.take(static_cast<double>(bytes.size()))) {
      if (phase_ == Phase::open) count(shared_.counters.cut_off, CutOff::flood);
      close(websocket::close_code::policy_error, "too many messages");
    } else if (phase_ == Phase::open) {
      shared_.events->on_message(id_, socket_.got_text(),
                                 {static_cast<const char*>(bytes.data()), bytes.size()});
    }
    buffer_.consume(buffer_.size());
    read_message();
  }

  void write_next() {
    // Beast writes one message at a time; later ones wait in the queue, where they can still be
    // dropped.
    if (is_writing_ || phase_ != Phase::open) return;
    auto frame = queue_.pop();
    if (!frame) return;
    current_ = std::move(*frame);
    is_writing_ = true;
    socket_.binary(!current_.is_text);
    const std::array<asio::const_buffer, 2> buffers{
        asio::buffer(current_.head.data(), current_.head_size),
        current_.body ? asio::buffer(*current_.body) : asio::const_buffer()};
    socket_.async_write(buffers,
                        beast::bind_front_handler(&WebConnection::on_written, shared_from_this()));
  }

  void on_written(beast::error_code error, std::size_t /*bytes*/) {
    is_writing_ = false;
    const Frame sent = std::exchange(current_, {});
    if (error) return end(false);
    ++shared_.counters.messages_sent;
    shared_.counters.bytes_sent += sent.size();
    write_next();
  }

  void ping(Clock::time_point now) {
    if (is_pinging_) return;
    is_pinging_ = true;
    pinged_ = now;
    socket_.async_ping({}, [self = shared_from_this()](beast::error_code) {
      self->is_pinging_ = false;  // a broken connection fails in its read
    });
  }

  void report_dropped(Clock::time_point now) {
    reported_ = now;
    const std::uint64_t dropped = queue_.take_dropped();
    if (dropped == 0) return;
    const std::string text = counted(dropped, "message was", "messages were") +
                             " dropped: this connection is too slow for its subscriptions";
    push_answer(text_frame(share(status_text(Level::warning, text))), false);
  }

  void close(websocket::close_code code, const char* reason) {
    if (phase_ != Phase::open) return;
    phase_ = Phase::closing;
    close_deadline_ = Clock::now() + kCloseTime;
    socket_.async_close({code, reason}, [self = shared_from_this()](beast::error_code) {
      self->end(false);
    });
  }

  Shared& shared_;
  const ConnectionId id_;
  const Use use_;
  Phase phase_ = Phase::http;
  /// Without compression, which the gateway does not offer.
  websocket::stream<beast::tcp_stream, false> socket_;
  beast::flat_buffer buffer_{kLongestMessage};
  std::optional<http::request_parser<http::string_body>> parser_;
  Response response_;
  SendQueue queue_;
  Frame current_;  ///< being sent
  bool is_writing_ = false;
  bool is_pinging_ = false;
  bool is_overfull_ = false;        ///< more answers wait than allowed
  bool has_announced_end_ = false;  ///< the client was told that the server ends
  TokenBucket messages_{kMessages};
  TokenBucket bytes_{kBytes};
  Patience patience_ = WebServer::kPatience;
  Clock::time_point received_{};
  Clock::time_point pinged_{};
  Clock::time_point reported_{};
  Clock::time_point close_deadline_{};
};

/// A listening socket.
struct Listener {
  Use use;
  tcp::acceptor acceptor;
  asio::steady_timer pause;
};

void open(tcp::acceptor& acceptor, const ListenAddress& listen) {
  bridge::listen_on(acceptor, listen.address, listen.port,
                    listen.address + " port " + std::to_string(listen.port));
}

}  // namespace

struct WebServer::State {
  State(WebSettings&& settings, Page page)
      : shared{.settings = std::move(settings), .page = page, .counters = {}} {}

  [[nodiscard]] WebConnection* find(ConnectionId id) {
    const auto found = connections.find(id);
    return found == connections.end() ? nullptr : found->second.get();
  }

  void accept(Listener& listener) {
    listener.acceptor.async_accept([this, &listener](beast::error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) {
        // For example too many open files: the open connections continue.
        listener.pause.expires_after(kAcceptPause);
        listener.pause.async_wait([this, &listener](beast::error_code ended) {
          if (!ended) accept(listener);
        });
        return;
      }
      serve(std::move(socket), listener.use);
      accept(listener);
    });
  }

  void serve(tcp::socket&& socket, Use use) {
    forget_ended();
    make_room(use);
    beast::error_code ignored;
    // Messages are shown as they arrive: they do not wait for the acknowledgement of earlier ones.
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
    const ConnectionId id = ++last_id;
    const auto connection = std::make_shared<WebConnection>(std::move(socket), shared, id, use);
    connections.emplace(id, connection);
    connection->start();
  }

  /// Makes room for a new connection: closes the oldest connection that has not opened a WebSocket,
  /// because a client normally sends its request immediately.
  void make_room(Use use) {
    const auto is_plain = [use](const auto& entry) {
      return entry.second->is_plain(use);
    };
    if (std::ranges::count_if(connections, is_plain) < kMostPlainConnections) return;
    std::ranges::find_if(connections, is_plain)->second->end(false);
    forget_ended();
  }

  void forget_ended() {
    std::erase_if(connections, [](const auto& entry) {
      return entry.second->is_over();
    });
  }

  void watch() {
    watch_timer.expires_after(kWatchPeriod);
    watch_timer.async_wait([this](beast::error_code error) {
      if (error) return;
      forget_ended();
      const auto now = Clock::now();
      const auto delay = now - watch_timer.expiry();
      const auto own_delay = delay > kWatchPeriod ? delay : Clock::duration::zero();
      // An event of one connection may affect others, but none is added or removed in this loop.
      for (const auto& [id, connection] : connections) connection->watch(now, own_delay);
      if (is_stopping && (connections.empty() || Clock::now() >= stop_deadline)) {
        context.stop();
      } else {
        watch();
      }
    });
  }

  void turn() {
    turn_timer.expires_after(kTurn);
    turn_timer.async_wait([this](beast::error_code error) {
      if (error) return;
      shared.events->on_turn();
      turn();
    });
  }

  void begin_to_stop() {
    if (std::exchange(is_stopping, true)) return;
    stop_deadline = Clock::now() + kCloseTime;
    beast::error_code ignored;
    clients.acceptor.close(ignored);
    metrics.acceptor.close(ignored);
    for (const auto& [id, connection] : connections) connection->announce_end();
  }

  asio::io_context context{1};
  Shared shared;
  Listener clients{.use = Use::clients,
                   .acceptor = tcp::acceptor(context),
                   .pause = asio::steady_timer(context)};
  Listener metrics{.use = Use::metrics,
                   .acceptor = tcp::acceptor(context),
                   .pause = asio::steady_timer(context)};
  asio::signal_set signals{context, SIGINT, SIGTERM};
  asio::steady_timer watch_timer{context};
  asio::steady_timer turn_timer{context};
  std::map<ConnectionId, std::shared_ptr<WebConnection>> connections;
  ConnectionId last_id = 0;
  bool is_stopping = false;
  Clock::time_point stop_deadline{};
};

WebServer::WebServer(WebSettings settings, Page page)
    : state_(std::make_unique<State>(std::move(settings), page)) {
  const WebSettings& kept = state_->shared.settings;
  open(state_->clients.acceptor, kept.listen);
  if (kept.metrics) open(state_->metrics.acceptor, *kept.metrics);
}

WebServer::~WebServer() = default;

std::uint16_t WebServer::port() const {
  return state_->clients.acceptor.local_endpoint().port();
}

std::optional<std::uint16_t> WebServer::metrics_port() const {
  const tcp::acceptor& acceptor = state_->metrics.acceptor;
  if (!acceptor.is_open()) return std::nullopt;
  return acceptor.local_endpoint().port();
}

const WebCounters& WebServer::counters() const noexcept {
  return state_->shared.counters;
}

void WebServer::run(WebEvents& events) {
  State& state = *state_;
  state.shared.events = &events;
  state.signals.async_wait([&state](beast::error_code error, int) {
    if (!error) state.begin_to_stop();
  });
  state.accept(state.clients);
  if (state.metrics.acceptor.is_open()) state.accept(state.metrics);
  state.watch();
  state.turn();
  state.context.run();
  // Also ends connections to which the end could not be announced in time, so that control is
  // released.
  for (const auto& [id, connection] : state.connections) {
    connection->announce_end();
    connection->end(true);
  }
  state.connections.clear();
  state.shared.events = nullptr;
}

void WebServer::stop() {
  asio::post(state_->context, [this] {
    state_->begin_to_stop();
  });
}

void WebServer::send_data(ConnectionId id, Frame frame) {
  if (WebConnection* const connection = state_->find(id)) connection->push_data(std::move(frame));
}

void WebServer::send_answer(ConnectionId id, Frame frame, bool is_shared) {
  if (WebConnection* const connection = state_->find(id)) {
    connection->push_answer(std::move(frame), is_shared);
  }
}

void WebServer::set_patience(ConnectionId id, Patience patience) {
  if (WebConnection* const connection = state_->find(id)) connection->set_patience(patience);
}

void WebServer::post(std::function<void()> action) {
  asio::post(state_->context, std::move(action));
}

}  // namespace vdrive::gateway
