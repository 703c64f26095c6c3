// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <mutex>

namespace vdrive::client {

/// What std::timed_mutex is. The thread sanitizer of gcc 12 does not see that std::timed_mutex is
/// locked where the deadline is one of the steady clock, and reports its unlock.
class TurnMutex {
 public:
  void lock() {
    std::unique_lock lock(mutex_);
    freed_.wait(lock, [this] {
      return !is_taken_;
    });
    is_taken_ = true;
  }

  /// @return false at the deadline.
  template <typename TimePoint>
  [[nodiscard]] bool try_lock_until(const TimePoint& deadline) {
    std::unique_lock lock(mutex_);
    const bool is_free = freed_.wait_until(lock, deadline, [this] {
      return !is_taken_;
    });
    if (is_free) is_taken_ = true;
    return is_free;
  }

  void unlock() {
    const std::scoped_lock lock(mutex_);
    is_taken_ = false;
    freed_.notify_one();
  }

 private:
  std::mutex mutex_;
  std::condition_variable freed_;
  bool is_taken_ = false;
};

}  // namespace vdrive::client
