// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/lazy_slots.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>

namespace vdrive::service {

/// Bounded, lock-free queue from one producer thread to one consumer thread. The producer fills a
/// slot in place, the consumer reads it in place, and a slot keeps the capacity of its sequences
/// for the next message, so nothing allocates once every slot has been used. An empty queue
/// restarts at its first slot: a queue that is seldom full uses few slots, which stay in the
/// caches; slots that were never used cost no memory (LazySlots).
template <typename Message>
class Ring {
 public:
  /// @param capacity [messages], at least 1
  explicit Ring(std::size_t capacity) : slots_(capacity) {}

  /// Producer: @return a slot to fill, or nullptr when the queue is full.
  [[nodiscard]] Message* free_slot() noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    const std::size_t read = first_of(head_.load(std::memory_order_acquire));
    if (tail - read == slots_.capacity()) return nullptr;
    const std::size_t rest = tail == read ? tail % slots_.capacity() : 0;
    filled_ = rest == 0 ? tail : tail - rest + slots_.capacity();
    return &slots_.reach(filled_ % slots_.capacity());
  }

  /// Producer: hands over the slot of the last `free_slot`.
  void push() noexcept {
    ensure(filled_ >= tail_.load(std::memory_order_relaxed), "a slot is handed over once");
    if (filled_ != tail_.load(std::memory_order_relaxed)) {
      begin_.store(filled_, std::memory_order_relaxed);
    }
    tail_.store(filled_ + 1, std::memory_order_release);
  }

  /// Consumer: @return the oldest message, or nullptr when there is none.
  [[nodiscard]] Message* front() noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return nullptr;
    return &slots_[first_of(head) % slots_.capacity()];
  }

  /// Consumer: gives back the slot of `front`.
  void pop() noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    ensure(head != tail_.load(std::memory_order_relaxed), "a message was at the front");
    head_.store(first_of(head) + 1, std::memory_order_release);
  }

  /// @return how many messages wait; exact only when no thread uses the queue.
  [[nodiscard]] std::size_t size() const noexcept {
    const std::size_t tail = tail_.load(std::memory_order_acquire);
    const std::size_t read = first_of(head_.load(std::memory_order_acquire));
    return tail > read ? std::min(tail - read, slots_.capacity()) : 0;
  }

  [[nodiscard]] std::size_t capacity() const noexcept { return slots_.capacity(); }

  /// Prepares every slot before the threads start, for example to reserve its sequences.
  template <typename Function>
  void for_each_slot(Function function) {
    for (std::size_t place = 0; place < capacity(); ++place) function(slots_.reach(place));
  }

 private:
  static constexpr std::size_t kCacheLine = 64;

  /// @return the position of the oldest message, or where the next one will be. Positions before
  ///         `begin_` hold no message, even if `head` is still there.
  [[nodiscard]] std::size_t first_of(std::size_t head) const noexcept {
    return std::max(head, begin_.load(std::memory_order_relaxed));
  }

  LazySlots<Message> slots_;  ///< constructed by the producer
  // Positions only grow; a message is in the slot of its position modulo the capacity.
  alignas(kCacheLine) std::atomic<std::size_t> head_{0};
  alignas(kCacheLine) std::atomic<std::size_t> tail_{0};
  std::atomic<std::size_t> begin_{0};  ///< where the queue restarted when it was last empty
  std::size_t filled_ = 0;             ///< for the producer: position of the last `free_slot`
};

}  // namespace vdrive::service
