// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace vdrive::service {

/// The state of a doorbell, in memory that two processes may share; initially zero.
struct BellState {
  std::atomic<std::uint32_t> rings{0};  ///< a futex
  std::atomic<std::uint32_t> waiting{0};
};

/// Wakes the one thread that waits for arrivals or records, in this process or another one. A ring
/// while no thread waits is remembered and costs no system call.
class Doorbell {
 public:
  /// How a thread waits. A sleeping thread takes some 10 us to wake, and waking it costs a system
  /// call.
  enum class Waiting : std::uint8_t {
    asleep,
    /// Polls for up to 100 us before it sleeps, if the previous ring came within that time.
    quick,
  };

  /// @param state outlives this
  explicit Doorbell(BellState& state, Waiting waiting = Waiting::asleep) noexcept
      : state_(state), waiting_(waiting) {}

  void ring() noexcept;

  /// For the waiting thread: waits until the bell has been rung since the last call.
  /// @return false on timeout
  bool wait_for(std::chrono::nanoseconds timeout) noexcept;

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] bool has_rung() const noexcept { return state_.rings.load() != received_; }

  void look_for_rings(Clock::time_point deadline) const noexcept;
  void sleep_until_rung(Clock::time_point deadline) noexcept;

  BellState& state_;
  Waiting waiting_;
  std::uint32_t received_ = 0;
  bool was_quick_ = false;  ///< the last ring came soon after the wait began
};

}  // namespace vdrive::service
