// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/pages.hpp"
#include "vdrive/assert.hpp"

#include <cstddef>
#include <memory>
#include <span>

namespace vdrive::service {

/// A fixed number of slots, each constructed when it is first reached. Address space for all of
/// them is reserved at the start, so nothing allocates later (unless the constructor of a slot
/// does), but the kernel provides a page only when it is first written: unused slots cost no memory
/// (Pages). For one thread.
template <typename Slot>
class LazySlots {
 public:
  explicit LazySlots(std::size_t capacity)
      : capacity_(capacity),
        pages_(capacity * sizeof(Slot)),
        // NOLINTNEXTLINE(*-reinterpret-cast): a page is aligned for any object
        slots_(reinterpret_cast<Slot*>(pages_.memory().data())) {}

  ~LazySlots() { std::destroy_n(slots_, made_); }

  LazySlots(const LazySlots&) = delete;
  LazySlots& operator=(const LazySlots&) = delete;

  /// @param place below the capacity
  /// @return the slot; it and all slots before it are constructed if they were not
  [[nodiscard]] Slot& reach(std::size_t place) {
    ensure(place < capacity_, "the place of a slot is below the capacity");
    for (; made_ <= place; ++made_) std::construct_at(slots_ + made_);
    return slots_[place];
  }

  /// @param place already reached
  [[nodiscard]] Slot& operator[](std::size_t place) noexcept { return slots_[place]; }

  [[nodiscard]] const Slot& operator[](std::size_t place) const noexcept { return slots_[place]; }

  [[nodiscard]] std::size_t capacity() const noexcept { return capacity_; }

  /// @return the slots that have been reached.
  [[nodiscard]] std::span<Slot> made() noexcept { return {slots_, made_}; }

 private:
  std::size_t capacity_;
  Pages pages_;
  Slot* slots_;
  std::size_t made_ = 0;
};

}  // namespace vdrive::service
