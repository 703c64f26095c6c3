// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calls/axes_call.hpp"
#include "vdrive/client/bench.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::client {

// For drives that act later than in the tick of the command (docs/guides/be-another-drive.md).

/// Within this time, a drive that evaluates its controlword in a loop of some milliseconds has
/// evaluated it.
inline constexpr std::chrono::milliseconds kLongestLoop{20};

/// A fault reset has taken effect within this time.
inline constexpr std::chrono::milliseconds kLongestReset{50};

/// How long a call waits for a drive that shows no change. After that, the present state counts as
/// its answer.
class AnswerTime {
 public:
  /// Counts from the tick that `call` has observed.
  /// @param call must outlive this
  AnswerTime(const AxesCall& call, std::chrono::nanoseconds time)
      : call_(call), end_(call.driven_tick() + ticks_of(time, call.period())) {}

  [[nodiscard]] bool has_ended() const { return call_.driven_tick() >= end_; }

 private:
  const AxesCall& call_;
  std::uint64_t end_;  // compared with driven_tick()
};

/// @return whether an axis that was commanded to Operation enabled has answered: it got there, has
///         a fault, or does nothing. In Switched on it is powering on, which may take any time.
[[nodiscard]] bool has_answered_enabling(const AxisSnapshot& axis, const AnswerTime& answer_time);

/// For axes that got all controlwords of enabling in one tick and have not reached Operation
/// enabled: a drive with a loop (5E20h:06) may have seen only the last one. Sends them one by one,
/// each after the previous one has taken effect.
/// @param places of these axes; axes already enabled, in a fault or without a loop are sent nothing
/// @return whether an axis got a controlword.
Result<bool> enable_step_by_step(AxesCall& call, std::span<const std::size_t> places);

/// Waits until a drive with a loop (5E20h:06) has seen the controlword in force.
Outcome await_controlword_loop(AxesCall& call);

/// Waits until no axis that got a quick stop is in Operation enabled any more, or until the longest
/// loop time has passed: until then, that state may date from before the stop.
Outcome await_stop_seen(AxesCall& call);

/// For axes whose fault has outlasted a pulse of bit 7: keeps the bit set until the fault has
/// ended, at most for kLongestReset, and clears it.
/// @param places of these axes
Outcome hold_reset(AxesCall& call, std::span<const std::size_t> places);

}  // namespace vdrive::client
