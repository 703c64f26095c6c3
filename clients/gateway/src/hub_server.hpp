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

/// Number of a WebSocket connection, never used twice in one run.
using ConnectionId = std::uint64_t;

/// How long a client may be silent before its connection is closed.
struct Patience {
  std::chrono::milliseconds program{};  ///< sends nothing and answers no ping
  std::chrono::milliseconds machine{};  ///< does not even acknowledge the bytes that it was sent
};

/// What the hub and its parts have their server do. In the server's thread, except `post`; a
/// connection that is closed already is ignored.
class HubServer {
 public:
  virtual ~HubServer() = default;

  /// Data: the oldest is dropped when the client is slow, and a status message has their number.
  virtual void send_data(ConnectionId id, Frame frame) = 0;

  /// An answer: never dropped; a client that lets too many wait is closed.
  /// @param is_shared others keep the bytes too
  virtual void send_answer(ConnectionId id, Frame frame, bool is_shared) = 0;

  /// How long this client may be silent from now on.
  virtual void set_patience(ConnectionId id, Patience patience) = 0;

  /// Calls `action` in the server's thread, later. Any thread.
  virtual void post(std::function<void()> action) = 0;

  void send_text(ConnectionId id, std::string text) {
    send_answer(id, text_frame(share(std::move(text))), false);
  }

  void send_status(ConnectionId id, Level level, std::string_view text) {
    send_text(id, status_text(level, text));
  }
};

}  // namespace vdrive::gateway
