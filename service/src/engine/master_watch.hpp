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

/// The watchdog of the masters: a session that owns axes must send something in time. Masters run
/// by the wall clock, so they get more ticks when drive time runs faster.
class MasterWatch {
 public:
  MasterWatch(const Configuration& configuration, const BenchClock& clock, Masters& masters,
              Counters& counters);

  /// Takes the axes from every master that has been silent for too long, and notes the longest
  /// silence.
  void watch();

  /// Follows a change of the clock's rate: the silence of every master counts from now.
  void follow_rate();

  /// Follows a jump of the tick number, which does not count as silence of a master.
  void skip(std::uint64_t ticks);

 private:
  [[nodiscard]] std::chrono::microseconds time_of(std::uint64_t ticks) const noexcept;
  [[nodiscard]] std::uint64_t patience() const noexcept;

  const BenchClock& clock_;
  Masters& masters_;
  Counters& counters_;
  std::chrono::microseconds period_;
  std::uint64_t longest_silence_ = 0;                  ///< [ticks]
  std::optional<std::chrono::milliseconds> watchdog_;  ///< permitted silence at rates up to 1
  std::uint64_t ticks_;                                ///< permitted silence [ticks]; 0 = off
};

}  // namespace vdrive::service
