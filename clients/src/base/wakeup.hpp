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

/// Wakes the calls that wait when something may have changed, and ends them on an interrupt. Holds
/// nothing of what they wait for: each condition locks the state that it reads, and no call holds a
/// lock of a state while it waits. In a forked process interrupts do nothing, since another thread
/// of the parent may have had the lock; no call gets as far as a wait there, see
/// Discovery::check_process. Thread-safe.
class Wakeup {
 public:
  using Clock = std::chrono::steady_clock;

  /// Before the first wait: `work` is what a thread that is about to wait for a bench does first
  /// (wire::Participant::run_local_work).
  void work_with(std::function<wire::LocalWork(std::uint32_t bench)> work) {
    work_ = std::move(work);
  }

  /// Something has changed. To be called after the change.
  void notify();

  /// Ends the calls that may be interrupted, now and later.
  void interrupt() noexcept;

  /// Later calls wait again.
  void end_interrupt() noexcept;

  /// @return whether the call of this thread is to end.
  [[nodiscard]] bool is_interrupted() const;

  /// @return whether a call of this thread stops axes.
  [[nodiscard]] bool is_stopping() const noexcept;

  /// A call of this thread that stops axes, while it lives. A program that was interrupted can
  /// still stop what moves: only a later interrupt ends the call.
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

  /// @return the number of changes. A call that reads it before its condition misses
  ///         no change after it.
  [[nodiscard]] std::uint64_t changes() const;

  /// Works for the bench as long as there is some work and there were no more than `changes`.
  /// @return whether there was some.
  bool work(std::uint64_t changes, std::uint32_t bench);

  /// Works for the bench, then waits until there were more than `changes`, or for the deadline. A
  /// wait that another thread works for ends after a millisecond: this one may have to go on.
  void work_until(std::uint64_t changes, std::uint32_t bench, Clock::time_point deadline);

  /// Waits until there were more than `changes`, or for the deadline.
  void wait_until(std::uint64_t changes, Clock::time_point deadline);

 private:
  struct Worked {
    bool has_worked = false;
    bool is_elsewhere = false;  ///< the rest
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
