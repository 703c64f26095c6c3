// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace vdrive::service {

/// The only source of time for the realtime clock; tests replace it.
class CycleTimer {
 public:
  CycleTimer() = default;
  CycleTimer(const CycleTimer&) = delete;
  CycleTimer& operator=(const CycleTimer&) = delete;
  virtual ~CycleTimer() = default;

  /// @return time that never jumps, since an arbitrary start.
  [[nodiscard]] virtual std::chrono::nanoseconds monotonic_now() noexcept = 0;

  /// @return time since 1970.
  [[nodiscard]] virtual std::chrono::nanoseconds wall_now() noexcept = 0;

  /// Returns at or after the monotonic time `deadline`.
  virtual void wait_until(std::chrono::nanoseconds deadline) noexcept = 0;
};

/// The clocks of this machine.
class SystemCycleTimer final : public CycleTimer {
 public:
  [[nodiscard]] std::chrono::nanoseconds monotonic_now() noexcept override;
  [[nodiscard]] std::chrono::nanoseconds wall_now() noexcept override;
  void wait_until(std::chrono::nanoseconds deadline) noexcept override;
};

}  // namespace vdrive::service
