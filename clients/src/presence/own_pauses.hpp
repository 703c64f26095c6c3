// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace vdrive::client {

/// For how long this program did not run, because it was stopped or the machine was busy: in such a
/// time it receives nothing, which says nothing about a bench. A time between two notes beyond
/// kLongestGap is such a pause. Time is an argument. Not thread-safe.
class OwnPauses {
 public:
  using Clock = std::chrono::steady_clock;

  /// A program that runs notes the time at least this often.
  static constexpr std::chrono::milliseconds kPeriod{50};
  /// Three notes: a busy machine is late by less all the time.
  static constexpr std::chrono::milliseconds kLongestGap{150};

  explicit OwnPauses(Clock::time_point now) : newest_(now) {}

  /// The program runs now.
  /// @return the pause that has ended with this, 0 when there was none.
  Clock::duration note(Clock::time_point now);

  /// @return all pauses together.
  [[nodiscard]] Clock::duration total() const noexcept { return total_; }

 private:
  Clock::time_point newest_;
  Clock::duration total_{};
};

}  // namespace vdrive::client
