// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clock/cycle_timer.hpp"
#include "engine/bench_engine.hpp"

#include <atomic>
#include <chrono>

namespace vdrive::service {

/// The last 1.5 s of a bench. Any thread requests the end; the thread that steps the bank brings
/// the axes to rest: first on their ramp, then with a quick stop, and finally by removing their
/// power.
class Shutdown {
 public:
  /// Wall time since the request. A service must end within 2 s; the rest is for announcing its
  /// end.
  static constexpr std::chrono::milliseconds kLongestRamp{1000};
  static constexpr std::chrono::milliseconds kLongest{1500};

  Shutdown(BenchEngine& engine, CycleTimer& timer) noexcept;

  /// Requests the end. Any thread. Idempotent.
  void begin() noexcept;

  /// @return whether braking is over: no axis has power any more, the time is up, or drive time
  ///         stands still, so that no axis can brake. Any thread.
  [[nodiscard]] bool is_done() const noexcept { return done_.load(std::memory_order_acquire); }

  /// Brakes the axes. For the thread that steps the bank, between two ticks. Costs nothing before
  /// `begin`.
  void advance() noexcept;

 private:
  void brake(Braking braking) noexcept;

  BenchEngine& engine_;
  CycleTimer& timer_;
  std::atomic<std::chrono::nanoseconds::rep> begin_{0};  ///< monotonic, 0 = not yet
  std::atomic<bool> done_{false};
  Braking braking_ = Braking::none;  ///< valid if `is_braking_`
  bool is_braking_ = false;
};

}  // namespace vdrive::service
