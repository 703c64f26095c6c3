// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>

namespace vdrive::wire {

/// Decides how long a channel that was idle sleeps after a datagram, so that the following ones
/// collect in its socket and one wakeup serves many. The more arrives in a pause, the shorter the
/// next one is: the socket's buffer must never be the limit. For one thread.
class ReceiveCoalescing {
 public:
  using Clock = std::chrono::steady_clock;

  /// Bytes that may collect in a pause. The kernel's default buffer holds three times as many.
  static constexpr std::size_t kMostOfPause = std::size_t{64} * 1024;

  /// A datagram that is received more than this long after the channel began to receive again was
  /// not waiting in the socket: the channel was idle.
  static constexpr std::chrono::microseconds kIdle{100};

  /// @param longest pause; 0 = none
  explicit ReceiveCoalescing(std::chrono::microseconds longest) noexcept
      : longest_(longest), pause_(longest) {}

  /// @param arrived when the datagram was received
  /// @return the time to sleep once it has been processed; 0 while more datagrams are waiting.
  [[nodiscard]] std::chrono::microseconds pause_after(std::size_t bytes,
                                                      Clock::time_point arrived) noexcept;

  /// The channel is about to receive again.
  void resumed(Clock::time_point now) noexcept { resumed_ = now; }

 private:
  std::chrono::microseconds longest_;
  std::chrono::microseconds pause_;  ///< the last one, or the first one to come
  std::size_t bytes_ = 0;            ///< since the last pause began
  Clock::time_point resumed_{};
};

}  // namespace vdrive::wire
