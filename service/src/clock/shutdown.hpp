// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clock/cycle_timer.hpp"
#include "engine/bench_engine.hpp"

#include <atomic>
#include <chrono>

namespace vdrive::service {

/// The last second and a half of a bench. Any thread requests the end; the thread that steps the
/// bank brings the axes to rest: on their ramp first, then with the quick stop, then without power.
class Shutdown {
 public:
  /// Wall time from the request on. The rest of the 2 s that a service has is for the announcement
  /// of its end.
  static constexpr std::chrono::milliseconds kLongestRamp{1000};
  static constexpr std::chrono::milliseconds kLongest{1500};

  Shutdown(BenchEngine& engine, CycleTimer& timer) noexcept;

  /// Any thread. Idempotent.
  void begin() noexcept;

  /// Any thread: no axis has power any more, or there is no way to brake them: time is up, or
  /// stands still.
  [[nodiscard]] bool is_done() const noexcept { return done_.load(std::memory_order_acquire); }

  /// The thread that steps the bank, between two ticks. Free until `begin`.
  void advance() noexcept;

 private:
  void brake(Braking braking) noexcept;

  BenchEngine& engine_;
  CycleTimer& timer_;
  std::atomic<std::chrono::nanoseconds::rep> begin_{0};  ///< monotonic, 0 = not yet
  std::atomic<bool> done_{false};
  Braking braking_ = Braking::none;  ///< holds when `is_braking_`
  bool is_braking_ = false;
};

}  // namespace vdrive::service
