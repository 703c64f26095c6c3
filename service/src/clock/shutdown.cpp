// SPDX-License-Identifier: Apache-2.0
#include "clock/shutdown.hpp"

namespace vdrive::service {

Shutdown::Shutdown(BenchEngine& engine, CycleTimer& timer) noexcept
    : engine_(engine), timer_(timer) {}

void Shutdown::begin() noexcept {
  std::chrono::nanoseconds::rep not_yet = 0;
  begin_.compare_exchange_strong(not_yet, timer_.monotonic_now().count(),
                                 std::memory_order_relaxed);
}

void Shutdown::advance() noexcept {
  const auto begin = begin_.load(std::memory_order_relaxed);
  if (begin == 0 || is_done()) return;
  const auto passed = timer_.monotonic_now() - std::chrono::nanoseconds(begin);
  const bool time_is_up = passed >= kLongest || engine_.time_stands();
  if (!time_is_up) brake(passed < kLongestRamp ? Braking::ramp : Braking::quick_stop);
  if (time_is_up || !engine_.has_power()) done_.store(true, std::memory_order_release);
}

void Shutdown::brake(Braking braking) noexcept {
  if (!is_braking_ || braking_ != braking) {
    engine_.shut_down(braking);
    braking_ = braking;
    is_braking_ = true;
  }
}

}  // namespace vdrive::service
