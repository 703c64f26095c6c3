// SPDX-License-Identifier: Apache-2.0
#include "bus/socketcand_server.hpp"

#include "bus/asio.hpp"
#include "bus/socketcand.hpp"
#include "bus/tcp_acceptor.hpp"
#include "bus/waiting_frames.hpp"

#include <array>
#include <deque>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

// Bytes of one read: some 100 frames, so that others get their turn while a client floods the bus.
constexpr std::size_t kSocketcandInput = 4096;     // [bytes]
constexpr std::size_t kSocketcandOutput = 16'384;  // [bytes] of one write
// Kernel buffer: frames in it cannot be dropped any more, so a slow client sees them late.
constexpr int kSocketcandBuffer = 1 << 18;  // [bytes] in the kernel, which doubles it
// With more unread answers than this, the server stops reading from the client.
constexpr std::size_t kMostSocketcandReplies = 256;
// python-can rejects the answer to "rawmode" if further data arrive in the same block, so it could
// not connect to a busy bus. Frames are held back until the client sends something, which shows
// that it has read the answer; a client that only listens gets its first frames after this time.
constexpr std::chrono::milliseconds kQuietAfterRawmode{100};

/// Parts shared by the connections of a server. Bus and host are not used once the server is
/// destroyed.
struct SocketcandShared {
  Bus& bus;
  BusHost& host;
  SocketcandSettings settings;
  SocketcandCounters counters{};
};

class SocketcandConnection final : public Port,
                                   private SocketcandHost,
                                   public std::enable_shared_from_this<SocketcandConnection> {
 public:
  SocketcandConnection(tcp::socket&& socket, std::shared_ptr<SocketcandShared> shared)
      : shared_(std::move(shared)),
        socket_(std::move(socket)),
        quiet_timer_(socket_.get_executor()),
        statistics_timer_(socket_.get_executor()),
        frames_(socket_.get_executor(), shared_->bus, *this, shared_->settings.most_waiting_frames,
                shared_->settings.holds_bus),
        session_(*this) {}

  ~SocketcandConnection() override = default;
  SocketcandConnection(const SocketcandConnection&) = delete;
  SocketcandConnection& operator=(const SocketcandConnection&) = delete;

  void start() {
    shared_->bus.attach(*this);
    reply(kSocketcandGreeting);
    write_next();
    read();
  }

  void deliver(const Frame& frame) override {
    ++traffic_.received_frames;
    traffic_.received_bytes += frame.bytes().size();
    if (is_closing_ || session_.mode() != SocketcandMode::raw) return;
    if (!frames_.put({frame, shared_->host.frame_time()}, *this)) {
      ++shared_->counters.dropped_frames;
    }
    write_later();
  }

  void resume() override {
    asio::post(socket_.get_executor(), [self = shared_from_this()] {
      if (!self->is_over_) self->proceed();
    });
  }

  /// See WaitingFrames::put().
  void report_hold() const {
    if (is_over_) return;
    shared_->host.report(
        bridge::Severity::warning, "socketcand " + address_text(shared_->settings.listen),
        "a client is not reading: " + std::to_string(frames_.size()) +
            " frames are queued for it; bus and drive time stand still until it reads them or "
            "disconnects; a client that only sends should use '< bcmmode >'");
  }

  /// Leaves the bus and closes the connection.
  void end() {
    if (std::exchange(is_over_, true)) return;
    frames_.clear();
    shared_->bus.detach(*this);
    --shared_->counters.clients;
    cancel(quiet_timer_);
    cancel(statistics_timer_);
    AsioError ignored;
    socket_.close(ignored);
  }

  [[nodiscard]] bool is_over() const noexcept { return is_over_; }

 private:
  void reply(std::string_view text) override { replies_.emplace_back(text); }

  void send(const Frame& frame) override {
    ++traffic_.sent_frames;
    traffic_.sent_bytes += frame.bytes().size();
    ++shared_->counters.received_frames;
    shared_->bus.send(frame, this);
  }

  void read() {
    if (is_reading_ || has_sent_all_ || is_closing_ || !unread_.empty() || shared_->bus.is_held() ||
        replies_.size() > kMostSocketcandReplies) {
      return;
    }
    is_reading_ = true;
    socket_.async_read_some(asio::buffer(input_),
                            [self = shared_from_this()](const AsioError& error, std::size_t size) {
                              self->is_reading_ = false;
                              if (!self->is_over_) self->take(error, size);
                            });
  }

  void take(const AsioError& error, std::size_t size) {
    if (error && error != asio::error::eof) return end();
    has_sent_all_ = static_cast<bool>(error);
    unread_ = {input_.data(), size};
    end_quiet();
    proceed();
  }

  /// Handles the client's input, then continues to read.
  void proceed() {
    const SocketcandMode before = session_.mode();
    const std::uint64_t refused_before = session_.refused_words();
    take_words();
    shared_->counters.refused_words += session_.refused_words() - refused_before;
    if (session_.mode() != before) follow_mode();
    if (session_.statistics_period() != statistics_period_) follow_statistics();
    // A client that has shut down its sending side still reads the answers and the resulting
    // frames.
    if (session_.is_over() || (has_sent_all_ && unread_.empty())) return close_after_replies();
    write_next();
    read();
  }

  /// Word by word: each may cause frames for which a port has no room.
  void take_words() {
    while (!unread_.empty() && !shared_->bus.is_held()) {
      const std::size_t end_of_word = unread_.find('>');
      const std::size_t size =
          end_of_word == std::string_view::npos ? unread_.size() : end_of_word + 1;
      session_.take(unread_.substr(0, size));
      unread_.remove_prefix(size);
    }
  }

  void follow_mode() {
    if (session_.mode() != SocketcandMode::raw) return frames_.clear();
    is_quiet_ = true;
    quiet_timer_.expires_after(kQuietAfterRawmode);
    quiet_timer_.async_wait([self = shared_from_this()](const AsioError& error) {
      if (!error && !self->is_over_) self->end_quiet();
    });
  }

  void end_quiet() {
    if (!std::exchange(is_quiet_, false)) return;
    cancel(quiet_timer_);
    write_next();
  }

  void follow_statistics() {
    statistics_period_ = session_.statistics_period();
    cancel(statistics_timer_);
    if (statistics_period_ != std::chrono::milliseconds::zero()) await_statistics();
  }

  void await_statistics() {
    statistics_timer_.expires_after(statistics_period_);
    statistics_timer_.async_wait([self = shared_from_this()](const AsioError& error) {
      if (error || self->is_over_) return;
      // A client that does not read misses this one, and gets newer numbers later.
      if (self->replies_.empty()) self->reply(socketcand_statistics(self->traffic_));
      self->write_next();
      self->await_statistics();
    });
  }

  void close_after_replies() {
    is_closing_ = true;
    write_next();
  }

  void write_next() {
    if (is_writing_ || is_over_) return;
    output_.clear();
    frames_in_output_ = 0;
    if (!replies_.empty()) {
      // Sent alone, because clients take all the data of one receive call as one answer.
      output_ = std::move(replies_.front());
      replies_.pop_front();
    } else if (!is_quiet_) {
      append_frames();
    }
    if (output_.empty()) {
      if (is_closing_) end();
      return;
    }
    is_writing_ = true;
    asio::async_write(socket_, asio::buffer(output_),
                      [self = shared_from_this()](const AsioError& error, std::size_t /*bytes*/) {
                        self->is_writing_ = false;
                        if (!self->is_over_) self->on_written(error);
                      });
  }

  /// Writes at the end of this turn of the loop, so that all its output is one write.
  void write_later() {
    if (is_writing_ || std::exchange(is_write_posted_, true)) return;
    asio::post(socket_.get_executor(), [self = shared_from_this()] {
      self->is_write_posted_ = false;
      self->write_next();
    });
  }

  void append_frames() {
    while (!frames_.empty() && output_.size() < kSocketcandOutput) {
      append_socketcand_frame(output_, frames_.front().frame, frames_.front().time);
      frames_.pop();
      ++frames_in_output_;
    }
  }

  void on_written(const AsioError& error) {
    if (error) return end();
    shared_->counters.sent_frames += frames_in_output_;
    write_next();
    if (!is_over_) read();
  }

  std::shared_ptr<SocketcandShared> shared_;
  tcp::socket socket_;
  asio::steady_timer quiet_timer_;
  asio::steady_timer statistics_timer_;
  WaitingFrames frames_;
  SocketcandSession session_;
  SocketcandTraffic traffic_;
  std::chrono::milliseconds statistics_period_{};
  std::array<char, kSocketcandInput> input_{};
  std::string_view unread_;  ///< part of input_, while the bus is held
  std::deque<std::string> replies_;
  std::string output_;  ///< being sent
  std::uint64_t frames_in_output_ = 0;
  bool is_reading_ = false;
  bool is_writing_ = false;
  bool is_write_posted_ = false;
  bool is_quiet_ = false;  ///< frames wait; see kQuietAfterRawmode
  bool has_sent_all_ = false;
  bool is_closing_ = false;
  bool is_over_ = false;
};

}  // namespace

struct SocketcandServer::State final : TcpServer {
  State(asio::io_context& context, Bus& bus, BusHost& host, const SocketcandSettings& settings)
      : shared(std::make_shared<SocketcandShared>(
            SocketcandShared{.bus = bus, .host = host, .settings = settings})),
        acceptor(context, settings.listen, *this) {}

  void serve(tcp::socket&& socket) override {
    std::erase_if(connections, [](const auto& connection) {
      return connection->is_over();
    });
    if (connections.size() >= shared->settings.most_clients) {
      ++shared->counters.refused_clients;
      return turn_away(socket, "< error too many clients >");
    }
    AsioError ignored;
    socket.set_option(asio::socket_base::send_buffer_size(kSocketcandBuffer), ignored);
    ++shared->counters.connections;
    ++shared->counters.clients;
    connections.push_back(std::make_shared<SocketcandConnection>(std::move(socket), shared));
    connections.back()->start();
  }

  std::shared_ptr<SocketcandShared> shared;
  std::vector<std::shared_ptr<SocketcandConnection>> connections;
  TcpAcceptor acceptor;
};

SocketcandServer::SocketcandServer(asio::io_context& context, Bus& bus, BusHost& host,
                                   const SocketcandSettings& settings)
    : state_(std::make_unique<State>(context, bus, host, settings)) {}

SocketcandServer::~SocketcandServer() {
  state_->acceptor.close();
  for (const auto& connection : state_->connections) connection->end();
}

const TcpAddress& SocketcandServer::address() const noexcept {
  return state_->acceptor.address();
}

const SocketcandCounters& SocketcandServer::counters() const noexcept {
  return state_->shared->counters;
}

}  // namespace vdrive::canopen
