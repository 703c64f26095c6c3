// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/presence_by_age.hpp"

#include "vdrive/wire/guard.hpp"

#include <algorithm>

namespace vdrive::wire {
namespace {

// Others remove a program that is silent for kPatienceWithVdrive. They count from its last
// datagram, up to 0.1 s before its pause begins; the rest of the 0.5 s is a margin.
constexpr std::chrono::milliseconds kForgottenAfter =
    kPatienceWithVdrive - std::chrono::milliseconds{500};

}  // namespace

Presence::Clock::duration PresenceByAge::own_pauses(Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  const Clock::duration gap = now - newest_.value_or(now);
  newest_ = std::max(newest_.value_or(now), now);  // two threads may call out of order
  if (gap <= kLongestGap) return pauses_;
  const Clock::duration pause = gap - kPulse;
  pauses_ += pause;
  if (pause >= kForgottenAfter) excused_until_ = now - pauses_ + kTimeToBeFoundAgain;
  return pauses_;
}

std::optional<Presence::Clock::duration> PresenceByAge::silence(
    const Source& /*source*/, std::optional<Clock::time_point> newest_sample,
    Clock::time_point now) const noexcept {
  if (!newest_sample) return std::nullopt;
  return now - *newest_sample;
}

bool PresenceByAge::is_excused(Clock::time_point now) const {
  const std::scoped_lock lock(mutex_);
  return excused_until_ && now < *excused_until_;
}

}  // namespace vdrive::wire
