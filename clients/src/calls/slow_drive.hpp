// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calls/axes_call.hpp"
#include "vdrive/client/bench.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::client {

// Drives that do later what others do in the tick of the command (docs/guides/be-another-drive.md).

/// A drive that looks at its controlword once in a loop of some milliseconds has done so within
/// this time.
inline constexpr std::chrono::milliseconds kLongestLoop{20};

/// A fault reset has had its effect within this time.
inline constexpr std::chrono::milliseconds kLongestReset{50};

/// How long a call waits for a drive that shows nothing new. After that the drive has answered.
class AnswerTime {
 public:
  /// From the tick on that `call` has observed. @param call outlives this
  AnswerTime(const AxesCall& call, std::chrono::nanoseconds time)
      : call_(call), end_(call.driven_tick() + ticks_of(time, call.period())) {}

  [[nodiscard]] bool has_ended() const { return call_.driven_tick() >= end_; }

 private:
  const AxesCall& call_;
  std::uint64_t end_;  // as driven_tick()
};

/// @return whether an axis that was commanded to Operation enabled has answered: it is there, has a
///         fault, or does nothing. In Switched on power is on its way, for as long as that takes.
[[nodiscard]] bool has_answered_enabling(const AxisSnapshot& axis, const AnswerTime& answer_time);

/// For axes that were given the words of enabling in one tick and have not gone to Operation
/// enabled: a drive with a loop (5E20h:06) may have seen the last one only. It gets one word after
/// the other, each when the one before has had its effect.
/// @param places of these axes; the others, those in a fault and those without a loop get nothing
/// @return whether an axis got a word.
Result<bool> walk_to_operation(AxesCall& call, std::span<const std::size_t> places);

/// Waits until a drive with a loop (5E20h:06) has seen the word that is in force.
Outcome await_look(AxesCall& call);

/// Waits until no axis that was given a quick stop is in Operation enabled any more, or until it
/// has had the time of the longest loop: that state is the one before the stop.
Outcome await_stop_seen(AxesCall& call);

/// For axes whose fault has outlasted a pulse of bit 7: holds the bit until the fault has ended, or
/// for kLongestReset, and takes it back.
/// @param places of these axes
Outcome hold_reset(AxesCall& call, std::span<const std::size_t> places);

}  // namespace vdrive::client
