// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "admission.hpp"
#include "page.hpp"
#include "server_calls.hpp"
#include "web_counters.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::gateway {

/// Where a server listens.
struct ListenAddress {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0 = any free one
};

struct WebSettings {
  ListenAddress listen{};
  std::optional<ListenAddress> metrics{};  ///< nothing = metrics are not served
  AdmissionRules rules{};
  std::size_t most_clients = 32;  ///< WebSocket connections at a time
};

/// What a server reports, in its thread.
struct WebEvents {
  std::function<void(ConnectionId id)> opened;
  std::function<void(ConnectionId id, bool is_text, std::string_view bytes)> received;
  /// @param is_graceful the client closed the WebSocket by the closing handshake, and was not lost
  std::function<void(ConnectionId id, bool is_graceful)> closed;
  std::function<std::string()> metrics{};  ///< makes the text of /metrics
};

/// The web server of the gateway: a page over HTTP, and WebSocket connections that are bounded in
/// what they send, in what waits for them and in how long they may be silent. One thread.
class WebServer {
 public:
  /// Of a client without control. Each is pinged twice a second.
  static constexpr Patience kPatience{.program = std::chrono::milliseconds(10'000),
                                      .machine = std::chrono::milliseconds(10'000)};

  /// Listens.
  /// @param page outlives the server
  /// @throws std::runtime_error when it cannot listen there.
  WebServer(WebSettings settings, Page page);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;

  /// @return where the metrics are served; nothing when they are not.
  [[nodiscard]] std::optional<std::uint16_t> metrics_port() const;

  /// Serves until stop(), SIGINT or SIGTERM. On return every connection is closed, and `closed` was
  /// called for it.
  void run(WebEvents events);

  /// Ends run(). Any thread.
  void stop();

  /// Calls `action` each `period` in the thread of run(). Before run().
  void every(std::chrono::milliseconds period, std::function<void()> action);

  /// What the server does for its hub.
  [[nodiscard]] ServerCalls calls();

  [[nodiscard]] const WebCounters& counters() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vdrive::gateway
