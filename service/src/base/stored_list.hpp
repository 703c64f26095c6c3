// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/assert.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace vdrive::service {

/// A sequence of a message, stored in place: up to kMost items without allocation. Unused items are
/// never written, so they cost no memory in a large array of such lists.
template <typename Item, std::size_t kMost>
class StoredList {
 public:
  // NOLINTNEXTLINE(modernize-use-equals-default,*-member-init): the storage stays uninitialised
  StoredList() noexcept {}

  ~StoredList() { std::destroy_n(room(), made_); }

  StoredList(const StoredList&) = delete;
  StoredList& operator=(const StoredList&) = delete;

  [[nodiscard]] std::span<const Item> items() const noexcept { return {room(), size_}; }

  /// Copies all `items`, at most kMost.
  void assign(std::span<const Item> items) {
    size_ = 0;
    for (const Item& item : items) next() = item;
  }

  /// Swaps the items with `items` (at most kMost). Each item keeps the capacity of its sequences,
  /// and `items` keeps its own.
  void exchange(std::vector<Item>& items) {
    const std::size_t mine = size_;
    const std::size_t common = std::min(mine, items.size());
    std::swap_ranges(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(common), room());
    size_ = common;
    for (std::size_t place = common; place < items.size(); ++place) {
      next() = std::move(items[place]);
    }
    if (items.size() > mine) items.resize(mine);
    for (std::size_t place = common; place < mine; ++place) {
      items.push_back(std::move(room()[place]));
    }
  }

 private:
  [[nodiscard]] Item& next() {
    ensure(size_ < kMost, "a list of a message is within its bound");
    if (size_ == made_) std::construct_at(room() + made_++);
    return room()[size_++];
  }

  // NOLINTBEGIN(cppcoreguidelines-pro-type-reinterpret-cast): storage, filled item by item
  [[nodiscard]] Item* room() noexcept { return reinterpret_cast<Item*>(room_.data()); }

  [[nodiscard]] const Item* room() const noexcept {
    return reinterpret_cast<const Item*>(room_.data());
  }

  // NOLINTEND(cppcoreguidelines-pro-type-reinterpret-cast)

  std::size_t size_ = 0;
  std::size_t made_ = 0;  ///< constructed items; those after `size_` keep their capacity
  alignas(Item) std::array<std::byte, sizeof(Item) * kMost> room_;
};

}  // namespace vdrive::service
