// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/clock_mode.hpp"

#include <cstdint>

namespace vdrive::ros2 {

/// How far ahead of a bench its set-points are sent, in ticks. In lock-step, where the length of
/// the next step is not known, it does not depend on wall time.
class SetPointLead {
 public:
  /// @param period [s] of a tick
  SetPointLead(ClockMode clock, double period) : clock_(clock), period_(period) {}

  /// @param rate drive time over wall time
  void set_rate(double rate) noexcept { rate_ = rate; }

  /// @return ticks from the newest state to the first one that a new set-point can reach.
  [[nodiscard]] std::uint64_t lead() const;

  /// @return ticks that have set-points while a motion lasts: those of a trajectory outlast a pause
  ///         of the machine, positions that come from time to time are late by no more than needed.
  [[nodiscard]] std::uint64_t window(bool is_trajectory) const;

  /// @return ticks before the begin of a trajectory, from which on it is taken.
  [[nodiscard]] std::uint64_t ahead_of_trajectory() const;

  /// Set-points came too late: the machine, or the way to the bench, is slower than the lead.
  void lengthen() noexcept;

 private:
  [[nodiscard]] std::uint64_t ticks(double seconds) const;

  ClockMode clock_;
  double period_;
  double rate_ = 1.0;
  double lead_ = kShortest;  ///< [s of wall time]

  /// [s] Some turns of the controller: one that is late does not miss its tick.
  static constexpr double kShortest = 0.008;
};

}  // namespace vdrive::ros2
