// SPDX-License-Identifier: Apache-2.0
#include "seam/doorbell.hpp"

#include "base/relax.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <ctime>

namespace vdrive::service {
namespace {

// Futexes are used directly, because std::atomic::wait uses private ones, which do not work across
// processes.
static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t) &&
              std::atomic<std::uint32_t>::is_always_lock_free);

// If a ring came within this time, the next one is expected just as soon, and polling for it costs
// less than a sleep and a wake-up.
constexpr std::chrono::nanoseconds kLongestLook = std::chrono::microseconds(100);

void futex_wait(std::atomic<std::uint32_t>& word, std::uint32_t expected,
                std::chrono::nanoseconds timeout) noexcept {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(timeout);
  const timespec time{.tv_sec = seconds.count(), .tv_nsec = (timeout - seconds).count()};
  syscall(SYS_futex, &word, FUTEX_WAIT, expected, &time, nullptr, 0);  // NOLINT(*-vararg)
}

void futex_wake(std::atomic<std::uint32_t>& word) noexcept {
  syscall(SYS_futex, &word, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);  // NOLINT(*-vararg)
}

}  // namespace

void Doorbell::ring() noexcept {
  state_.rings.fetch_add(1);
  if (state_.waiting.load() != 0) futex_wake(state_.rings);
}

bool Doorbell::wait_for(std::chrono::nanoseconds timeout) noexcept {
  const auto begin = Clock::now();
  if (was_quick_) look_for_rings(begin + std::min(kLongestLook, timeout));
  if (!has_rung()) sleep_until_rung(begin + timeout);
  const std::uint32_t rings = state_.rings.load();
  const bool rung = rings != received_;
  received_ = rings;
  was_quick_ = waiting_ == Waiting::quick && rung && Clock::now() - begin < kLongestLook;
  return rung;
}

/// Does not yield: the scheduler might give a complete time slice to unimportant work, such as a
/// program of idle priority, and a ring would be noticed only after that slice.
void Doorbell::look_for_rings(Clock::time_point deadline) const noexcept {
  // Reading the clock takes longer than a look at the state.
  constexpr int kLooksPerReading = 32;
  do {
    for (int look = 0; look < kLooksPerReading; ++look) {
      if (has_rung()) return;
      relax();
    }
  } while (Clock::now() < deadline);
}

void Doorbell::sleep_until_rung(Clock::time_point deadline) noexcept {
  state_.waiting.store(1);
  std::uint32_t rings = state_.rings.load();
  while (rings == received_) {
    const auto left = deadline - Clock::now();
    if (left <= std::chrono::nanoseconds::zero()) break;
    futex_wait(state_.rings, rings, left);
    rings = state_.rings.load();
  }
  state_.waiting.store(0);
}

}  // namespace vdrive::service
