// SPDX-License-Identifier: Apache-2.0
#include "clock/tick_clock.hpp"

#include <algorithm>
#include <cmath>

namespace vdrive::service {
namespace {

/// Each tick corrects 1 / kSteeringHorizon of the offset, within the limit of steering.
constexpr double kSteeringHorizon = 200.0;

}  // namespace

TickClock::TickClock(std::chrono::microseconds period, double rate, const Instant& now,
                     WallStepPolicy policy) noexcept
    : period_(static_cast<double>(std::chrono::nanoseconds(period).count())),
      interval_(period_ / rate),
      steered_(rate == 1.0),
      wall_step_policy_(policy),
      next_tick_(static_cast<std::uint64_t>(now.wall / std::chrono::nanoseconds(period)) + 1) {
  const auto begin = std::chrono::nanoseconds(period) * static_cast<std::int64_t>(next_tick_);
  deadline_ = static_cast<double>((now.monotonic + (begin - now.wall)).count());
}

TickClock::TickClock(std::chrono::microseconds period, double rate, const Instant& now,
                     std::uint64_t next_tick, WallStepPolicy policy) noexcept
    : period_(static_cast<double>(std::chrono::nanoseconds(period).count())),
      interval_(period_ / rate),
      steered_(rate == 1.0),
      wall_step_policy_(policy),
      next_tick_(next_tick),
      deadline_(static_cast<double>(now.monotonic.count()) + interval_) {
  rebase(now);
}

void TickClock::set_rate(double rate, const Instant& now) noexcept {
  const auto monotonic = static_cast<double>(now.monotonic.count());
  const double ticks_left = (deadline_ - monotonic) / interval_;
  interval_ = period_ / rate;
  steered_ = rate == 1.0;
  deadline_ = monotonic + ticks_left * interval_;
  rebase(now);
}

/// Sets the reference so that the next tick is on time.
void TickClock::rebase(const Instant& now) noexcept {
  const std::int64_t due =
      static_cast<std::int64_t>(deadline_) + (now.wall - now.monotonic).count();
  reference_ = due - static_cast<std::int64_t>(period_) * static_cast<std::int64_t>(next_tick_);
  offset_ = 0.0;
  expected_ = 0.0;
  deviations_ = 0;
}

std::uint64_t TickClock::skip_backlog(std::chrono::nanoseconds monotonic_now) noexcept {
  const double late = static_cast<double>(monotonic_now.count()) - deadline_;
  if (late <= interval_ * static_cast<double>(kMaxBacklog)) return 0;
  const auto skipped = static_cast<std::uint64_t>(late / interval_);
  next_tick_ += skipped;
  deadline_ += interval_ * static_cast<double>(skipped);
  return skipped;
}

/// @return the wall time of the deadline minus the wall time at which this tick should have begun.
///         Computed in integers, which are exact; a double would round the time since 1970 to a
///         quarter of a microsecond.
double TickClock::read_offset(const Instant& now) const noexcept {
  const auto due = static_cast<std::int64_t>(deadline_) + (now.wall - now.monotonic).count();
  const auto begin =
      reference_ + static_cast<std::int64_t>(period_) * static_cast<std::int64_t>(next_tick_);
  return static_cast<double>(due - begin);
}

bool TickClock::sees_step() noexcept {
  constexpr double kLargest = std::chrono::duration<double, std::nano>(kStep).count();
  const double change = offset_ - expected_;
  if (std::abs(change) <= kLargest) {
    const double limit = interval_ * kMaxDrift;
    expected_ += std::clamp(change, -limit, limit);
    deviations_ = 0;
    return false;
  }
  if (++deviations_ < kReadings) return false;
  expected_ = offset_;
  deviations_ = 0;
  return true;
}

std::optional<WallStep> TickClock::watch_wall_clock() noexcept {
  if (!sees_step()) return std::nullopt;
  WallStep step{.offset = offset()};
  if (wall_step_policy_ == WallStepPolicy::jump && offset_ > 0.0) {
    step.jumped = static_cast<std::uint64_t>(std::llround(offset_ / period_));
    next_tick_ += step.jumped;
    offset_ -= static_cast<double>(step.jumped) * period_;
    expected_ = offset_;
  }
  return step;
}

std::optional<WallStep> TickClock::advance(const Instant& now) noexcept {
  std::optional<WallStep> step;
  double interval = interval_;
  if (steered_) {
    offset_ = read_offset(now);
    step = watch_wall_clock();
    const double limit = interval_ * kMaxSteering;
    interval -= std::clamp(offset_ / kSteeringHorizon, -limit, limit);
  }
  deadline_ += interval;
  ++next_tick_;
  return step;
}

}  // namespace vdrive::service
