// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "configuration/configuration.hpp"

#include <chrono>
#include <cstdint>

namespace vdrive::service {

/// The time of a bench: the number of its last completed tick, and how fast ticks follow each
/// other.
class BenchClock {
 public:
  /// The last completed tick is 0 until `start_at`.
  BenchClock(const Configuration& configuration, Counters& counters);

  /// Before the first step: the first tick is the one after `last_tick`.
  void start_at(std::uint64_t last_tick);

  void complete_tick();

  /// The tick number goes forward and the state of the axes is held.
  void jump(std::uint64_t ticks);

  void set_rate(double rate);

  /// Last completed tick.
  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }

  /// Ticks that the number jumped over since the start of the service: they were not run.
  [[nodiscard]] std::uint64_t skipped() const noexcept { return skipped_; }

  [[nodiscard]] std::uint64_t next_tick() const noexcept { return tick_ + 1; }

  [[nodiscard]] ClockMode mode() const noexcept { return mode_; }

  /// Realtime: drive time over wall time, 0 = paused. 0 in other clock modes.
  [[nodiscard]] double rate() const noexcept { return rate_; }

  /// @return whether no tick comes by itself: lock-step, or paused.
  [[nodiscard]] bool time_stands() const noexcept;

  /// @return the ticks that `time` takes, rounded up.
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
