// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "configuration/configuration.hpp"

#include <chrono>
#include <cstdint>

namespace vdrive::service {

/// The drive time of a bench: the number of its last completed tick, and the rate of the ticks.
class BenchClock {
 public:
  /// The last completed tick is 0 until `start_at`.
  BenchClock(const Configuration& configuration, Counters& counters);

  /// Sets the last completed tick. Only before the first step.
  void start_at(std::uint64_t last_tick);

  void complete_tick();

  /// Moves the tick number forward without running the ticks.
  void jump(std::uint64_t ticks);

  void set_rate(double rate);

  /// @return the last completed tick.
  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }

  /// @return the number of ticks jumped over (not run) since the start of the service.
  [[nodiscard]] std::uint64_t skipped() const noexcept { return skipped_; }

  [[nodiscard]] std::uint64_t next_tick() const noexcept { return tick_ + 1; }

  [[nodiscard]] ClockMode mode() const noexcept { return mode_; }

  /// @return the ratio of drive time to wall time in realtime, 0 = paused. 0 in other clock modes.
  [[nodiscard]] double rate() const noexcept { return rate_; }

  /// @return whether time stands still without a request: lock-step, or paused.
  [[nodiscard]] bool time_stands() const noexcept;

  /// @return the number of ticks in `time`, rounded up.
  [[nodiscard]] std::uint64_t ticks_in(std::chrono::microseconds time) const noexcept;

 private:
  Counters& counters_;
  ClockMode mode_;
  std::chrono::microseconds period_;
  double rate_;
  std::uint64_t tick_ = 0;
  std::uint64_t skipped_ = 0;
};

}  // namespace vdrive::service
