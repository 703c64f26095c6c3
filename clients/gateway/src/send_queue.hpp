// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace vdrive::gateway {

/// Bytes that several connections send, encoded once.
using SharedBytes = std::shared_ptr<const std::string>;

/// @return these bytes for the queues of all connections.
[[nodiscard]] inline SharedBytes share(std::string bytes) {
  return std::make_shared<const std::string>(std::move(bytes));
}

/// One WebSocket message: a head specific to the connection, and a body that others may share.
struct Frame {
  bool is_text = false;
  std::uint8_t head_size = 0;
  std::array<char, 13> head{};  ///< the longest one is for message data
  SharedBytes body;

  /// Size [bytes].
  [[nodiscard]] std::size_t size() const noexcept { return head_size + (body ? body->size() : 0); }
};

/// @return a text message.
[[nodiscard]] inline Frame text_frame(SharedBytes text) {
  return {.is_text = true, .body = std::move(text)};
}

/// Limits of the queue of one connection: large enough for some seconds of a page's data, and small
/// enough for a few tens of slow clients.
struct QueueLimits {
  std::size_t data_bytes = 2U << 20U;
  std::size_t data_frames = 4096;
  std::size_t answer_bytes = 1U << 20U;
  std::size_t answer_frames = 2048;
};

/// The messages waiting to be sent to one client: answers, which are never dropped, before data, of
/// which the oldest is dropped when the queue is full. Not thread-safe.
class SendQueue {
 public:
  explicit SendQueue(const QueueLimits& limits = {}) : limits_(limits) {}

  /// Appends data and drops the oldest data beyond the limits.
  /// @return the number of dropped frames.
  std::size_t push_data(Frame frame);

  /// Appends an answer.
  /// @param is_shared other connections hold the same bytes, so they do not count here
  /// @return false if the answers exceed their limits because the client does not read them.
  [[nodiscard]] bool push_answer(Frame frame, bool is_shared = false);

  /// @return the frame to send next; nothing if the queue is empty.
  [[nodiscard]] std::optional<Frame> pop();

  /// @return the number of data frames dropped since the last call.
  [[nodiscard]] std::uint64_t take_dropped() noexcept;

  /// @return the waiting bytes, without shared ones.
  [[nodiscard]] std::size_t bytes() const noexcept { return data_bytes_ + answer_bytes_; }

 private:
  struct Answer {
    Frame frame;
    std::size_t cost = 0;
  };

  QueueLimits limits_;
  std::deque<Answer> answers_;
  std::deque<Frame> data_;
  std::size_t answer_bytes_ = 0;
  std::size_t data_bytes_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace vdrive::gateway
