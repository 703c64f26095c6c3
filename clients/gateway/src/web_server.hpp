// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "admission.hpp"
#include "hub_server.hpp"
#include "page.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::gateway {

/// The address that a server listens on.
struct ListenAddress {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0 = any free port
};

struct WebSettings {
  ListenAddress listen{};
  std::optional<ListenAddress> metrics{};  ///< nothing = metrics are not served
  AdmissionRules rules{};
  std::size_t most_clients = 32;  ///< WebSocket connections at a time
};

/// Why the gateway closed a WebSocket before its client did.
enum class CutOff : std::uint8_t {
  silent,  ///< it sent nothing for too long
  unread,  ///< too many answers waited for it
  flood,   ///< it sent too much
};

inline constexpr std::size_t kCutOffs = 3;

/// @return such as "silent".
[[nodiscard]] constexpr std::string_view to_string(CutOff cut_off) noexcept {
  constexpr std::array<std::string_view, kCutOffs> kNames{"silent", "unread", "flood"};
  return kNames[static_cast<std::size_t>(cut_off)];
}

/// Counters of a server since its start, unless noted otherwise.
struct WebCounters {
  std::size_t clients = 0;                         ///< open WebSockets
  std::uint64_t connections = 0;                   ///< opened WebSockets
  std::uint64_t messages_sent = 0;                 ///< WebSocket messages handed to the kernel
  std::uint64_t bytes_sent = 0;                    ///< of their payload
  std::uint64_t dropped = 0;                       ///< messages dropped for slow clients
  std::array<std::uint64_t, kRefusals> refused{};  ///< by Refusal
  std::array<std::uint64_t, kCutOffs> cut_off{};   ///< by CutOff
};

/// Receives the events of a server, in its thread.
class WebEvents {
 public:
  virtual ~WebEvents() = default;

  virtual void on_open(ConnectionId id) = 0;
  virtual void on_message(ConnectionId id, bool is_text, std::string_view bytes) = 0;

  /// @param is_graceful the client closed the WebSocket by the closing handshake; false: it was
  ///        lost
  virtual void on_close(ConnectionId id, bool is_graceful) = 0;

  /// Every half second.
  virtual void on_turn() = 0;

  /// @return the text of /metrics.
  [[nodiscard]] virtual std::string metrics() const = 0;
};

/// The web server of the gateway: a page over HTTP, and WebSocket connections with limits on what
/// they send, on their queues and on their silence. One thread.
class WebServer final : public HubServer {
 public:
  /// For a client without control. Every client is pinged twice a second.
  static constexpr Patience kPatience{.program = std::chrono::milliseconds(10'000),
                                      .machine = std::chrono::milliseconds(10'000)};

  /// Starts to listen.
  /// @param page outlives the server
  /// @throws std::runtime_error when it cannot listen there.
  WebServer(WebSettings settings, Page page);
  ~WebServer() override;
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;

  /// @return the port of the metrics; nothing if they are not served.
  [[nodiscard]] std::optional<std::uint16_t> metrics_port() const;

  /// Serves until stop(), SIGINT or SIGTERM. On return every connection is closed, and on_close()
  /// has been called for each WebSocket.
  void run(WebEvents& events);

  /// Ends run(). Thread-safe.
  void stop();

  void send_data(ConnectionId id, Frame frame) override;
  void send_answer(ConnectionId id, Frame frame, bool is_shared) override;
  void set_patience(ConnectionId id, Patience patience) override;
  void post(std::function<void()> action) override;

  [[nodiscard]] const WebCounters& counters() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vdrive::gateway
