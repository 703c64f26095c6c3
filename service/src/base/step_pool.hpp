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

/// Threads that share the work of a tick. Each takes a contiguous part, the calling thread the
/// first one. The result does not depend on the number of threads. Idle threads spin briefly, then
/// sleep.
class StepPool {
 public:
  /// @param threads including the calling one, at least 1; no more are used than the bank has
  ///        groups
  StepPool(AxisBank& bank, std::size_t threads);
  ~StepPool();
  StepPool(const StepPool&) = delete;
  StepPool& operator=(const StepPool&) = delete;

  /// Steps the bank by one tick; returns when all groups are done.
  void step() noexcept;

  /// Calls `work(first, last)` in each thread for its part of [0, count); returns when all are
  /// done. A thread gets the same share of `count` as of the groups, so that it finds the data that
  /// it wrote in its caches.
  /// @param work must not throw
  template <typename Work>
  void share(std::size_t count, const Work& work) noexcept {
    share({.call =
               [](const void* shared, std::size_t first, std::size_t last) {
                 (*static_cast<const Work*>(shared))(first, last);
               },
           .work = &work,
           .count = count});
  }

  /// Gives the threads the scheduling policy and priority of the calling thread. If that is a
  /// realtime policy and the process has exactly one processor per thread, each thread is bound to
  /// one of them.
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
  std::chrono::microseconds longest_spin_;  ///< zero if there are more threads than processors
  Task task_{};                             ///< of the present round
  std::vector<std::thread> helpers_;
  // On separate cache lines, because waiting threads poll them.
  alignas(kCacheLine) std::atomic<std::uint32_t> round_{0};
  alignas(kCacheLine) std::atomic<std::uint32_t> unfinished_{0};
  std::atomic<bool> stop_{false};
};

}  // namespace vdrive::service
