// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/wire/origin.hpp"
#include "vdrive/wire/participant.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <utility>

namespace vdrive::client {

/// Wakes waiting calls when something may have changed, and ends them on an interrupt. Holds none
/// of the state that they wait for: each condition locks the state that it reads, and no call holds
/// such a lock while it waits. In a forked process, interrupts do nothing, because another thread
/// of the parent may have held the lock of this object during the fork; no call gets as far as a
/// wait there, see Discovery::check_process. Thread-safe.
class Wakeup {
 public:
  using Clock = std::chrono::steady_clock;

  /// Sets the work that a thread does for a bench before it waits for that bench
  /// (wire::Participant::run_local_work). Call this before the first wait.
  void work_with(std::function<wire::LocalWork(std::uint32_t bench)> work) {
    work_ = std::move(work);
  }

  /// Reports a change. Call this after making the change.
  void notify();

  /// Ends the calls that can be interrupted, now and later.
  void interrupt() noexcept;

  /// From now on, calls wait again.
  void end_interrupt() noexcept;

  /// @return whether the current call of this thread must end.
  [[nodiscard]] bool is_interrupted() const;

  /// @return whether the current call of this thread stops axes.
  [[nodiscard]] bool is_stopping() const noexcept;

  /// Marks a call of this thread that stops axes, for its lifetime. An interrupted program can
  /// still stop axes: only an interrupt during the call ends it.
  class StopInProgress {
   public:
    explicit StopInProgress(const Wakeup& wakeup);
    ~StopInProgress();
    StopInProgress(const StopInProgress&) = delete;
    StopInProgress& operator=(const StopInProgress&) = delete;

   private:
    const Wakeup* const outer_wakeup_;
    const std::uint64_t outer_interrupts_;
  };

  /// @return the number of changes. A call that reads it before it checks its condition misses no
  ///         later change.
  [[nodiscard]] std::uint64_t changes() const;

  /// Does the work of the bench while there is some and the number of changes is still `changes`.
  /// @return whether there was any work.
  bool work(std::uint64_t changes, std::uint32_t bench);

  /// Does the work of the bench, then waits until the number of changes exceeds `changes`, or until
  /// the deadline. If another thread is working for the bench, the wait ends after a millisecond,
  /// because this thread may have to take over.
  void work_until(std::uint64_t changes, std::uint32_t bench, Clock::time_point deadline);

  /// Waits until the number of changes exceeds `changes`, or until the deadline.
  void wait_until(std::uint64_t changes, Clock::time_point deadline);

 private:
  struct Worked {
    bool has_worked = false;
    bool is_elsewhere = false;  ///< another thread does the rest
  };

  Worked work_while(std::uint64_t changes, std::uint32_t bench);

  const wire::Origin origin_;
  std::function<wire::LocalWork(std::uint32_t bench)> work_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t changes_ = 0;
  std::uint64_t interrupts_ = 0;
  std::uint64_t ended_interrupts_ = 0;
};

}  // namespace vdrive::client
