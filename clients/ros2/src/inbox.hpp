// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/ros.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <stop_token>
#include <variant>

namespace vdrive::ros2 {

using Message = std::variant<ros::JointState, ros::JointTrajectory, ros::Bool>;

/// A message of ROS, and who wrote it.
struct Received {
  wire::WriterId writer;
  Message message;
};

/// Brings messages from the threads of DDS to the one that commands, and wakes it. Thread-safe.
class Inbox {
 public:
  /// What has arrived.
  struct Content {
    std::deque<Received> messages;
    std::uint64_t dropped = 0;  ///< messages that found no room since the last take()
  };

  /// Does not wait. When it is full the oldest message is dropped and counted: the newest command
  /// is the one that counts.
  void put(Received received);

  void wake();

  [[nodiscard]] Content take();

  /// Waits for a message or wake(), at most for `duration`.
  void wait(std::chrono::milliseconds duration, const std::stop_token& stop);

 private:
  std::mutex mutex_;
  std::condition_variable_any woken_;
  bool is_woken_ = false;
  Content content_;
};

}  // namespace vdrive::ros2
