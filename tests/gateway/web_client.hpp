// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace vdrive::test {

/// Options of a connection to a gateway.
struct WebOptions {
  std::uint16_t port = 0;
  std::string subprotocol = "foxglove.sdk.v1";  ///< empty = offer none
  std::string origin{};                         ///< empty = send none
  std::string target = "/";
  int receive_buffer = 0;  ///< of the socket [bytes]; 0 = system default
};

struct WebMessage {
  bool is_text = false;
  std::string bytes;
};

/// A WebSocket client. It reads and answers pings only inside receive().
class WebClient {
 public:
  /// @throws std::runtime_error if the connection fails
  explicit WebClient(const WebOptions& options);

  /// Ends the connection without a close frame.
  ~WebClient();
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  /// @return the subprotocol chosen by the gateway.
  [[nodiscard]] const std::string& subprotocol() const noexcept;

  void send(const std::string& bytes, bool is_text);

  /// Sends bytes unchanged, ignoring the WebSocket protocol.
  void send_raw(const std::string& bytes);

  /// @return the next message; std::nullopt after `patience`, or if the connection has ended.
  std::optional<WebMessage> receive(std::chrono::milliseconds patience);

  /// @return whether the gateway ended the connection; see receive().
  [[nodiscard]] bool has_ended() const noexcept;

  /// Performs the closing handshake.
  void close();

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// A TCP connection that sends nothing.
class SilentConnection {
 public:
  /// @throws std::runtime_error if the connection fails
  explicit SilentConnection(std::uint16_t port);
  ~SilentConnection();
  SilentConnection(const SilentConnection&) = delete;
  SilentConnection& operator=(const SilentConnection&) = delete;

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// Exchanges an HTTP request, which must ask the server to close the connection.
/// @return the response, head and body
[[nodiscard]] std::string http_exchange(std::uint16_t port, const std::string& request);

}  // namespace vdrive::test
