// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/bounded_queue.hpp"
#include "vdrive/wire/ros.hpp"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <stop_token>
#include <variant>

namespace vdrive::ros2 {

using Message = std::variant<ros::JointState, ros::JointTrajectory, ros::Bool>;

/// A ROS message and its writer.
struct Received {
  wire::WriterId writer;
  Message message;
};

/// Passes messages from the DDS threads to the commanding thread, and wakes it. Thread-safe.
class Inbox {
 public:
  /// The most messages that may wait: more than half a second of commands at 100 Hz. A trajectory
  /// may have 4 MB.
  static constexpr std::size_t kMostMessages = 64;

  /// The messages that have arrived.
  struct Content {
    std::deque<Received> messages;
    std::uint64_t dropped = 0;  ///< messages dropped since the last take()
  };

  /// Does not wait. When full, the oldest message is dropped and counted, because the newest
  /// command is the one that matters.
  void put(Received received);

  void wake();

  [[nodiscard]] Content take();

  /// Waits for a message or wake(), at most for `duration`.
  void wait(std::chrono::milliseconds duration, const std::stop_token& stop);

 private:
  std::mutex mutex_;
  std::condition_variable_any woken_;
  bool is_woken_ = false;
  BoundedQueue<Received> messages_{kMostMessages, WhenFull::drops_oldest};
  std::uint64_t reported_ = 0;  ///< number of dropped messages already reported
};

}  // namespace vdrive::ros2
