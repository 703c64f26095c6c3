// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace vdrive::service {

/// What a doorbell is made of, in memory that two processes may share; zero at the beginning.
struct BellState {
  std::atomic<std::uint32_t> rings{0};  ///< a futex
  std::atomic<std::uint32_t> waiting{0};
};

/// Wakes the one thread that waits, for arrivals or for records, in this process or in another. A
/// ring while no thread waits is remembered and costs no system call.
class Doorbell {
 public:
  /// How the waiting thread waits. A thread that sleeps takes some 10 us to wake, and a system call
  /// of the one that wakes it.
  enum class Waiting : std::uint8_t {
    asleep,
    /// Polls for up to 100 us before it sleeps, as long as rings come that quickly.
    quick,
  };

  /// @param state outlives this
  explicit Doorbell(BellState& state, Waiting waiting = Waiting::asleep) noexcept
      : state_(state), waiting_(waiting) {}

  void ring() noexcept;

  /// The waiting thread: waits for a ring since the last call. @return false on time-out.
  bool wait_for(std::chrono::nanoseconds timeout) noexcept;

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] bool has_rung() const noexcept { return state_.rings.load() != received_; }

  void look_for_rings(Clock::time_point deadline) const noexcept;
  void sleep_until_rung(Clock::time_point deadline) noexcept;

  BellState& state_;
  Waiting waiting_;
  std::uint32_t received_ = 0;
  bool was_quick_ = false;  ///< the last ring came soon after the wait for it had begun
};

}  // namespace vdrive::service
