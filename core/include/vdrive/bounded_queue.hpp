// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

namespace vdrive {

/// How a full queue handles a new item.
enum class WhenFull : std::uint8_t {
  drops_oldest,   ///< drops the oldest item to make room
  refuses_newest  ///< refuses the new item; put() returns false
};

/// A queue of bounded length that counts the items it had no room for. Not thread-safe. It
/// allocates, so do not use it in a step of a drive.
template <typename Item>
class BoundedQueue {
 public:
  /// @param most the largest number of waiting items, at least 1
  BoundedQueue(std::size_t most, WhenFull when_full) : most_(most), when_full_(when_full) {}

  /// @return false when the item was refused.
  bool put(Item item) {
    if (items_.size() == most_) {
      ++dropped_;
      if (when_full_ == WhenFull::refuses_newest) return false;
      items_.pop_front();
    }
    items_.push_back(std::move(item));
    return true;
  }

  /// @return the oldest item, or nothing when the queue is empty.
  std::optional<Item> take() {
    if (items_.empty()) return std::nullopt;
    std::optional<Item> item(std::move(items_.front()));
    items_.pop_front();
    return item;
  }

  /// @return all items, oldest first, and leaves the queue empty.
  std::deque<Item> take_all() { return std::exchange(items_, {}); }

  void clear() { items_.clear(); }

  [[nodiscard]] bool empty() const noexcept { return items_.empty(); }

  [[nodiscard]] std::size_t size() const noexcept { return items_.size(); }

  /// @return the waiting items, oldest first.
  [[nodiscard]] const std::deque<Item>& items() const noexcept { return items_; }

  /// @return how many items have been dropped or refused since construction.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }

 private:
  std::size_t most_;
  WhenFull when_full_;
  std::deque<Item> items_;
  std::uint64_t dropped_ = 0;
};

}  // namespace vdrive
