// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "configuration/configuration.hpp"
#include "engine/bench_clock.hpp"
#include "engine/masters.hpp"

#include <chrono>
#include <cstdint>
#include <optional>

namespace vdrive::service {

/// The watchdog of the masters: a session that owns axes has to send something in time. Masters
/// live by the wall clock: where drive time runs faster, they have more ticks.
class MasterWatch {
 public:
  MasterWatch(const Configuration& configuration, const BenchClock& clock, Masters& masters,
              Counters& counters);

  /// Takes the axes from every master that was silent for too long, and notes the longest silence.
  void watch();

  /// The rate of the clock has changed: the time of every master begins anew.
  void follow_rate();

  /// The tick number went forward: that is no silence of a master.
  void skip(std::uint64_t ticks);

 private:
  [[nodiscard]] std::chrono::microseconds time_of(std::uint64_t ticks) const noexcept;
  [[nodiscard]] std::uint64_t patience() const noexcept;

  const BenchClock& clock_;
  Masters& masters_;
  Counters& counters_;
  std::chrono::microseconds period_;
  std::uint64_t longest_silence_ = 0;                  ///< [ticks]
  std::optional<std::chrono::milliseconds> watchdog_;  ///< at a rate of 1 or below
  std::uint64_t ticks_;                                ///< that a master may be silent; 0 = off
};

}  // namespace vdrive::service
