// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace vdrive::client {

/// Wakes the calls that wait when something may have changed, and ends them on an interrupt. Holds
/// nothing of what they wait for: each condition locks the state that it reads, and no call holds a
/// lock of a state while it waits. Thread-safe.
class Wakeup {
 public:
  using Clock = std::chrono::steady_clock;

  /// Something has changed. To be called after the change.
  void notify();

  /// Ends the calls that may be interrupted, now and later.
  void interrupt() noexcept;
  [[nodiscard]] bool is_interrupted() const;

  /// @return the number of changes. A call that reads it before its condition misses
  ///         no change after it.
  [[nodiscard]] std::uint64_t changes() const;

  /// Waits until there were more than `changes`, or for the deadline.
  void wait_until(std::uint64_t changes, Clock::time_point deadline);

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t changes_ = 0;
  bool is_interrupted_ = false;
};

}  // namespace vdrive::client
