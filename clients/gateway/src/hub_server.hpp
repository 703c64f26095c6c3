// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "protocol.hpp"
#include "send_queue.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::gateway {

/// Number of a WebSocket connection, unique in a run.
using ConnectionId = std::uint64_t;

/// How long a client may be silent before its connection is closed.
struct Patience {
  std::chrono::milliseconds program{};  ///< sends nothing and answers no ping
  std::chrono::milliseconds machine{};  ///< does not even acknowledge the bytes sent to it
};

/// The server as the hub and its parts use it. Functions are called in the server's thread, except
/// `post`; calls for a closed connection are ignored.
class HubServer {
 public:
  virtual ~HubServer() = default;

  /// Sends data: if the client is slow, the oldest are dropped, and a status message reports their
  /// number.
  virtual void send_data(ConnectionId id, Frame frame) = 0;

  /// Sends an answer, which is never dropped; a client that lets too many accumulate is
  /// disconnected.
  /// @param is_shared other connections hold the same bytes
  virtual void send_answer(ConnectionId id, Frame frame, bool is_shared) = 0;

  /// Sets how long this client may be silent from now on.
  virtual void set_patience(ConnectionId id, Patience patience) = 0;

  /// Calls `action` later in the server's thread. Thread-safe.
  virtual void post(std::function<void()> action) = 0;

  void send_text(ConnectionId id, std::string text) {
    send_answer(id, text_frame(share(std::move(text))), false);
  }

  void send_status(ConnectionId id, Level level, std::string_view text) {
    send_text(id, status_text(level, text));
  }
};

}  // namespace vdrive::gateway
