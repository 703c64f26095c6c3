// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace vdrive::client {

/// What waits for the thread that reports it to the program: a thread that delivers samples puts it
/// here and waits for nothing. Of more than `kMost` the oldest are dropped. Thread-safe.
template <typename Item, std::size_t kMost>
class ReportQueue {
 public:
  void put(Item item) {
    {
      const std::scoped_lock lock(mutex_);
      if (items_.size() == kMost) items_.pop_front();
      items_.push_back(std::move(item));
    }
    changed_.notify_all();
  }

  /// Waits for an item. @return the oldest; nothing once a stop is requested.
  std::optional<Item> next(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    const bool has_one = changed_.wait(lock, stop, [this] {
      return !items_.empty();
    });
    if (!has_one || stop.stop_requested()) return std::nullopt;
    Item item = std::move(items_.front());
    items_.pop_front();
    return item;
  }

  /// Drops what waits.
  void clear() {
    const std::scoped_lock lock(mutex_);
    items_.clear();
  }

  /// Waits for that time, or until a stop is requested.
  void pause(const std::stop_token& stop, std::chrono::milliseconds period) {
    std::unique_lock lock(mutex_);
    static_cast<void>(changed_.wait_for(lock, stop, period, [] {
      return false;
    }));
  }

 private:
  std::mutex mutex_;
  std::deque<Item> items_;
  std::condition_variable_any changed_;
};

}  // namespace vdrive::client
