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

/// Wakes the one thread that waits for arrivals, in this process or in another. A ring while nobody
/// waits is remembered and costs no system call.
class Doorbell {
 public:
  /// @param state outlives this
  explicit Doorbell(BellState& state) noexcept : state_(state) {}

  void ring() noexcept;

  /// The waiting thread: waits for a ring since the last call. @return false on time-out.
  bool wait_for(std::chrono::nanoseconds timeout) noexcept;

 private:
  BellState& state_;
  std::uint32_t heard_ = 0;
};

}  // namespace vdrive::service
