// SPDX-License-Identifier: Apache-2.0
#include "clock/cycle_timer.hpp"

#include <cerrno>
#include <ctime>

namespace vdrive::service {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::chrono::nanoseconds now(clockid_t clock) noexcept {
  timespec time{};
  clock_gettime(clock, &time);
  return std::chrono::nanoseconds{time.tv_sec * kSecond + time.tv_nsec};
}

}  // namespace

std::chrono::nanoseconds SystemCycleTimer::monotonic_now() noexcept {
  return now(CLOCK_MONOTONIC);
}

std::chrono::nanoseconds SystemCycleTimer::wall_now() noexcept {
  return now(CLOCK_REALTIME);
}

void SystemCycleTimer::wait_until(std::chrono::nanoseconds deadline) noexcept {
  const timespec time{.tv_sec = deadline.count() / kSecond, .tv_nsec = deadline.count() % kSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) {
  }
}

}  // namespace vdrive::service
