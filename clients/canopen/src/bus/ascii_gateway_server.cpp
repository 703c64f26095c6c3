// SPDX-License-Identifier: Apache-2.0
#include "bus/ascii_gateway_server.hpp"

#include "bus/asio.hpp"
#include "bus/line_reader.hpp"
#include "bus/tcp_acceptor.hpp"
#include "vdrive/bounded_queue.hpp"

#include <array>
#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::canopen {
namespace {

constexpr std::size_t kGatewayInput = 4096;  // [bytes] of one read
// The server does not read from a client with this many waiting lines; the current block may add
// some more.
constexpr std::size_t kMostWaitingLines = 32;
// Nor does it read from a client with this much unread output.
constexpr std::size_t kMostGatewayAnswers = 1U << 18U;  // [bytes]
constexpr std::size_t kMostGatewayReports = 1U << 16U;  // [bytes] queued together with answers
// Frames queued until the gateway runs: SDO answers, boot-ups, emergencies and PDOs.
constexpr std::size_t kMostAwaitedFrames = 4096;

BusTime gateway_time() {
  return std::chrono::duration_cast<BusTime>(std::chrono::steady_clock::now().time_since_epoch());
}

struct GatewayClient {
  GatewayClient(tcp::socket&& its_socket, GatewaySession its_session)
      : socket(std::move(its_socket)), session(its_session) {}

  tcp::socket socket;
  GatewaySession session;
  LineReader lines{AsciiGatewayServer::kLongestLine};
  std::array<char, kGatewayInput> input{};
  std::string waiting;  ///< lines to send
  std::string output;   ///< being sent
  bool is_reading = false;
  bool is_writing = false;
  bool has_sent_all = false;
  bool is_over = false;
};

using GatewayClientPointer = std::shared_ptr<GatewayClient>;

}  // namespace

/// The gateway is called only by operations of the context, never by the bus: a port must not send
/// while a frame is delivered to it.
struct AsciiGatewayServer::State final : Port,
                                         TcpServer,
                                         GatewayHost,
                                         std::enable_shared_from_this<AsciiGatewayServer::State> {
  State(asio::io_context& its_context, Bus& its_bus, BusHost& its_host,
        const AsciiGatewayServerSettings& settings)
      : context(its_context),
        bus(its_bus),
        host(its_host),
        most_clients(settings.most_clients),
        gateway(settings.gateway, *this),
        timer(its_context),
        acceptor(its_context, settings.listen, *this) {}

  ~State() override = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void stop() {
    if (std::exchange(is_over, true)) return;
    acceptor.close();
    cancel(timer);
    for (const auto& [session, client] : clients) end(*client);
    bus.detach(*this);
  }

  void deliver(const Frame& frame) override {
    if (!gateway.awaits(frame)) return;
    if (!inbox.put(frame)) {
      ++counters.dropped_frames;
      return;
    }
    if (std::exchange(is_inbox_posted, true)) return;
    asio::post(context, [self = shared_from_this()] {
      self->is_inbox_posted = false;
      if (!self->is_over) self->take_inbox();
    });
  }

  // ---- GatewayHost

  void send(const Frame& frame) override { bus.send(frame, this); }

  void answer(GatewaySession session, std::string_view line) override {
    ++counters.commands;
    append_line(session, line);
  }

  void report(GatewaySession session, std::string_view line) override {
    const auto found = clients.find(session);
    if (found != clients.end() && found->second->waiting.size() >= kMostGatewayReports) {
      ++counters.dropped_reports;
    } else {
      append_line(session, line);
    }
  }

  std::optional<std::string> disturb(std::uint8_t node, std::string_view fault) override {
    return host.disturb(node, fault);
  }

  void append_line(GatewaySession session, std::string_view line) {
    const auto found = clients.find(session);
    if (found == clients.end()) return;
    found->second->waiting += line;
    found->second->waiting += "\r\n";
  }

  // ---- clients

  /// Posted as a separate turn, because each SYNC may cause many frames.
  void post_sync() {
    if (!gateway.has_syncs() || bus.is_held() || std::exchange(is_sync_posted, true)) return;
    asio::post(context, [self = shared_from_this()] {
      self->is_sync_posted = false;
      if (!self->is_over) self->send_sync();
    });
  }

  void send_sync() {
    if (!bus.is_held()) gateway.send_sync(gateway_time());
    settle();
  }

  void resume() override {
    asio::post(context, [self = shared_from_this()] {
      if (!self->is_over) self->settle();
    });
  }

  void take_inbox() {
    for (const Frame& frame : inbox.take_all()) gateway.receive(frame, gateway_time());
    settle();
  }

  void serve(tcp::socket&& socket) override {
    if (clients.size() >= most_clients) {
      ++counters.refused_clients;
      // Not an answer of CiA 309-3, as there was no command: a line for people.
      return turn_away(socket, "ERROR: too many clients\r\n");
    }
    ++counters.connections;
    ++counters.clients;
    const GatewaySession session = gateway.open();
    const auto client = std::make_shared<GatewayClient>(std::move(socket), session);
    clients.emplace(session, client);
    read(client);
  }

  [[nodiscard]] bool is_behind(const GatewayClient& client) const {
    return bus.is_held() || gateway.waiting(client.session) >= kMostWaitingLines ||
           client.waiting.size() >= kMostGatewayAnswers;
  }

  void read(const GatewayClientPointer& client) {
    if (client->is_over || client->is_reading || client->has_sent_all || is_behind(*client)) return;
    client->is_reading = true;
    client->socket.async_read_some(
        asio::buffer(client->input),
        [self = shared_from_this(), client](const AsioError& error, std::size_t size) {
          client->is_reading = false;
          if (!client->is_over) self->take(*client, error, size);
        });
  }

  void take(GatewayClient& client, const AsioError& error, std::size_t size) {
    if (error == asio::error::eof) {
      client.has_sent_all = true;
    } else if (error) {
      end(client);
    } else {
      client.lines.append({client.input.data(), size});
      take_lines(client);
    }
    settle();
  }

  /// Checks the bus before each line: any line may cause frames for which a port has no room.
  void take_lines(GatewayClient& client) {
    while (!bus.is_held()) {
      const auto line = client.lines.next();
      if (!line) return;
      take_line(client.session, *line);
    }
  }

  void take_line(GatewaySession session, const StreamLine& line) {
    std::string_view text = line.text;
    // Of a line that is too long, only the sequence number is passed on, and the answer is a syntax
    // error: the truncated line could be a valid command.
    if (line.is_too_long) text = text.substr(0, text.find(' '));
    gateway.take_line(session, text, gateway_time());
  }

  void write(const GatewayClientPointer& client) {
    if (client->is_over || client->is_writing || client->waiting.empty()) return;
    client->is_writing = true;
    client->output = std::exchange(client->waiting, {});
    asio::async_write(
        client->socket, asio::buffer(client->output),
        [self = shared_from_this(), client](const AsioError& error, std::size_t /*bytes*/) {
          client->is_writing = false;
          if (client->is_over) return;
          if (error) self->end(*client);
          self->settle();
        });
  }

  /// Called after any activity of the gateway: continues with every client and with the timer.
  void settle() {
    for (const auto& [session, client] : clients) {
      if (!client->is_over) take_lines(*client);  // lines that waited while the bus was held
      write(client);
      read(client);
      const bool is_served = client->has_sent_all && !client->is_over && !client->is_writing &&
                             gateway.waiting(session) == 0 && !bus.is_held();
      if (is_served) end(*client);
    }
    std::erase_if(clients, [](const auto& entry) {
      return entry.second->is_over;
    });
    await_due();
    post_sync();
  }

  void end(GatewayClient& client) {
    if (std::exchange(client.is_over, true)) return;
    --counters.clients;
    AsioError ignored;
    client.socket.close(ignored);
    gateway.close(client.session, gateway_time());
  }

  void await_due() {
    const auto due = gateway.next_due();
    if (due == awaited) return;
    awaited = due;
    if (!due) {
      cancel(timer);
      return;
    }
    timer.expires_at(std::chrono::steady_clock::time_point(*due));
    timer.async_wait([self = shared_from_this()](const AsioError& error) {
      if (error || self->is_over) return;
      self->awaited.reset();
      self->gateway.advance(gateway_time());
      self->settle();
    });
  }

  asio::io_context& context;
  Bus& bus;
  BusHost& host;
  std::size_t most_clients;
  AsciiGatewayCounters counters;
  AsciiGateway gateway;
  std::map<GatewaySession, GatewayClientPointer> clients;
  BoundedQueue<Frame> inbox{kMostAwaitedFrames, WhenFull::refuses_newest};
  bool is_inbox_posted = false;
  bool is_sync_posted = false;
  bool is_over = false;
  std::optional<BusTime> awaited;  ///< time that the timer is set to
  asio::steady_timer timer;
  TcpAcceptor acceptor;
};

AsciiGatewayServer::AsciiGatewayServer(boost::asio::io_context& context, Bus& bus, BusHost& host,
                                       const AsciiGatewayServerSettings& settings)
    : state_(std::make_shared<State>(context, bus, host, settings)) {
  bus.attach(*state_);
}

AsciiGatewayServer::~AsciiGatewayServer() {
  state_->stop();
}

const TcpAddress& AsciiGatewayServer::address() const noexcept {
  return state_->acceptor.address();
}

const AsciiGatewayCounters& AsciiGatewayServer::counters() const noexcept {
  return state_->counters;
}

}  // namespace vdrive::canopen
