// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace vdrive::test {

/// How a test connects to a gateway.
struct WebOptions {
  std::uint16_t port = 0;
  std::string subprotocol = "foxglove.sdk.v1";  ///< empty = offers none
  std::string origin{};                         ///< empty = sends none
  std::string target = "/";
  int receive_buffer = 0;  ///< of the socket [bytes]; 0 = the system's
};

struct WebMessage {
  bool is_text = false;
  std::string bytes;
};

/// A WebSocket client. It reads, and answers pings, only inside receive().
class WebClient {
 public:
  /// @throws std::runtime_error when there is no connection
  explicit WebClient(const WebOptions& options);

  /// The connection ends without a close frame.
  ~WebClient();
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  /// @return the subprotocol that the gateway chose.
  [[nodiscard]] const std::string& subprotocol() const noexcept;

  void send(const std::string& bytes, bool is_text);

  /// Sends bytes unchanged, without regard to the WebSocket protocol.
  void send_raw(const std::string& bytes);

  /// @return the next message; nothing after `patience`, or when the connection has ended.
  std::optional<WebMessage> receive(std::chrono::milliseconds patience);

  /// @return whether the gateway ended the connection; see receive().
  [[nodiscard]] bool has_ended() const noexcept;

  /// Closes by the protocol.
  void close();

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// A TCP connection that sends nothing.
class SilentConnection {
 public:
  /// @throws std::runtime_error when there is no connection
  explicit SilentConnection(std::uint16_t port);
  ~SilentConnection();
  SilentConnection(const SilentConnection&) = delete;
  SilentConnection& operator=(const SilentConnection&) = delete;

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// @return the answer to an HTTP request, head and body; it must request that the server closes.
[[nodiscard]] std::string http_exchange(std::uint16_t port, const std::string& request);

}  // namespace vdrive::test
