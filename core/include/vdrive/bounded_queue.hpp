// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

namespace vdrive {

/// What a full queue gives up.
enum class WhenFull : std::uint8_t {
  drops_oldest,   ///< the newest value counts
  refuses_newest  ///< who puts it hears of it
};

/// A queue that holds so many items at most and counts those that found no room. Not thread-safe;
/// allocates, and is not for a step of a drive.
template <typename Item>
class BoundedQueue {
 public:
  /// @param most items that wait, at least 1
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

  /// @return the oldest item; none when it is empty.
  std::optional<Item> take() {
    if (items_.empty()) return std::nullopt;
    std::optional<Item> item(std::move(items_.front()));
    items_.pop_front();
    return item;
  }

  /// @return all items, oldest first; the queue is empty then.
  std::deque<Item> take_all() { return std::exchange(items_, {}); }

  void clear() { items_.clear(); }

  [[nodiscard]] bool empty() const noexcept { return items_.empty(); }

  [[nodiscard]] std::size_t size() const noexcept { return items_.size(); }

  /// @return the items that wait, oldest first.
  [[nodiscard]] const std::deque<Item>& items() const noexcept { return items_; }

  /// @return how many items were dropped or refused, ever.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }

 private:
  std::size_t most_;
  WhenFull when_full_;
  std::deque<Item> items_;
  std::uint64_t dropped_ = 0;
};

}  // namespace vdrive
