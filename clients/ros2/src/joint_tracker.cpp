// SPDX-License-Identifier: Apache-2.0
#include "joint_tracker.hpp"

#include <algorithm>
#include <cmath>

namespace vdrive::ros2 {
namespace {

/// The speed from which constant deceleration in ticks comes to rest within this distance:
/// v dt + (v - a dt) dt + ... = v²/2a + v dt/2.
double speed_that_stops(double way, double ramp, double period) noexcept {
  const double half = 0.5 * ramp * period;
  return std::sqrt(half * half + 2.0 * ramp * way) - half;
}

}  // namespace

void JointTracker::stop(const JointLimits& limits) noexcept {
  const double way = 0.5 * now_.velocity * std::abs(now_.velocity) / limits.ramp;
  goal_ = now_.position + way;
  reference_ = goal_;
  left_ = 0.0;
}

JointMotion JointTracker::step(double period, const JointLimits& limits) noexcept {
  reference_ = left_ > period ? reference_ + (goal_ - reference_) * period / left_ : goal_;
  left_ = std::max(0.0, left_ - period);
  const double way = goal_ - now_.position;
  const double fastest =
      std::min(limits.velocity, speed_that_stops(std::abs(way), limits.ramp, period));
  const double wanted = std::clamp((reference_ - now_.position) / period,
                                   way < 0.0 ? -fastest : 0.0, way > 0.0 ? fastest : 0.0);
  // The ramp takes precedence: a speed above a limit that was just lowered is reduced along it.
  const double most = limits.ramp * period;
  const double speed = std::clamp(wanted, now_.velocity - most, now_.velocity + most);
  const double before = now_.velocity;
  now_ = {now_.position + speed * period, speed, (speed - before) / period};
  // A remaining distance below the rounding error of the steps counts as arrived.
  const double rest = std::abs(goal_ - now_.position);
  const double small = 1e-9 * std::max(1.0, std::abs(goal_));
  if (left_ == 0.0 && rest < small && std::abs(speed) <= most) now_ = {goal_, 0.0, 0.0};
  return now_;
}

double ValueLine::step(double period, double slope) noexcept {
  const double way = goal_ - now_;
  const double most = slope * period;
  if (left_ <= period && std::abs(way) <= most) {
    now_ = goal_;  // exactly, regardless of rounding in the sum of the steps
  } else {
    const double part = left_ > period ? way * period / left_ : way;
    now_ += std::clamp(part, -most, most);
  }
  left_ = std::max(0.0, left_ - period);
  return now_;
}

}  // namespace vdrive::ros2
