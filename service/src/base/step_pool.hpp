// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_bank.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

namespace vdrive::service {

/// Threads that share the work of a tick: each takes a contiguous part, the calling thread the
/// first one. The result does not depend on the number of threads. Idle threads spin briefly, then
/// sleep.
class StepPool {
 public:
  /// @param threads including the calling one, at least 1; more than there are groups of the bank
  ///        stay idle
  StepPool(AxisBank& bank, std::size_t threads);
  ~StepPool();
  StepPool(const StepPool&) = delete;
  StepPool& operator=(const StepPool&) = delete;

  /// One tick of the bank; returns when every group was stepped.
  void step() noexcept;

  /// Calls `work(first, last)` for parts that together are 0 to `count`, of one thread each;
  /// returns when all have ended. The part of a thread is in the same place as its part of the
  /// groups, so that what it has written is still near.
  /// @param work throws nothing
  template <typename Work>
  void share(std::size_t count, const Work& work) noexcept {
    share({.call =
               [](const void* shared, std::size_t first, std::size_t last) {
                 (*static_cast<const Work*>(shared))(first, last);
               },
           .work = &work,
           .count = count});
  }

  /// The threads get the scheduling policy and the priority of the calling thread. Where that is a
  /// realtime policy and the process has exactly one processor a thread, each is bound to its own.
  void schedule_as_caller() noexcept;

  [[nodiscard]] std::size_t threads() const noexcept { return parts_; }

 private:
  struct Task {
    void (*call)(const void* work, std::size_t first, std::size_t last);
    const void* work;
    std::size_t count;
  };

  static constexpr std::size_t kCacheLine = 64;

  void share(const Task& task) noexcept;
  void work(std::size_t part) noexcept;
  void do_part(std::size_t part) const noexcept;

  AxisBank& bank_;
  std::size_t parts_;
  std::chrono::microseconds longest_spin_;  ///< none where threads wait for a processor
  Task task_{};                             ///< of the present round
  std::vector<std::thread> helpers_;
  // On lines of their own: waiting threads read them all the time.
  alignas(kCacheLine) std::atomic<std::uint32_t> round_{0};
  alignas(kCacheLine) std::atomic<std::uint32_t> unfinished_{0};
  std::atomic<bool> stop_{false};
};

}  // namespace vdrive::service
