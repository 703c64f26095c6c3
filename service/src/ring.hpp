// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace vdrive::service {

/// Bounded queue from one producer thread to one consumer thread without locks. Messages stay where
/// they are: the producer fills a slot in place, the consumer reads it in place, and a slot keeps
/// the capacity of its sequences for the next message. So nothing allocates once it is warm.
template <typename Message>
class Ring {
 public:
  /// @param capacity how many messages fit, at least 1
  explicit Ring(std::size_t capacity) : slots_(capacity + 1) {}

  /// Producer: @return a slot to fill, or nullptr when the queue is full.
  [[nodiscard]] Message* free_slot() noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    return next(tail) == head_.load(std::memory_order_acquire) ? nullptr : &slots_[tail];
  }

  /// Producer: hands the slot of the last `free_slot` over.
  void push() noexcept {
    tail_.store(next(tail_.load(std::memory_order_relaxed)), std::memory_order_release);
  }

  /// Consumer: @return the oldest message, or nullptr when there is none.
  [[nodiscard]] Message* front() noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    return head == tail_.load(std::memory_order_acquire) ? nullptr : &slots_[head];
  }

  /// Consumer: gives the slot of `front` back.
  void pop() noexcept {
    head_.store(next(head_.load(std::memory_order_relaxed)), std::memory_order_release);
  }

  /// @return how many messages wait; exact only when nobody works on the queue.
  [[nodiscard]] std::size_t size() const noexcept {
    const std::size_t head = head_.load(std::memory_order_acquire);
    const std::size_t tail = tail_.load(std::memory_order_acquire);
    return tail >= head ? tail - head : tail + slots_.size() - head;
  }

  [[nodiscard]] std::size_t capacity() const noexcept { return slots_.size() - 1; }

  /// Prepares every slot before the threads start, for example reserves its sequences.
  template <typename Function>
  void for_each_slot(Function function) {
    for (auto& slot : slots_) function(slot);
  }

 private:
  static constexpr std::size_t kCacheLine = 64;

  [[nodiscard]] std::size_t next(std::size_t position) const noexcept {
    return position + 1 == slots_.size() ? 0 : position + 1;
  }

  std::vector<Message> slots_;
  alignas(kCacheLine) std::atomic<std::size_t> head_{0};
  alignas(kCacheLine) std::atomic<std::size_t> tail_{0};
};

}  // namespace vdrive::service
