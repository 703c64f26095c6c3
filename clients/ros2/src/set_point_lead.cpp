// SPDX-License-Identifier: Apache-2.0
#include "set_point_lead.hpp"

#include <algorithm>
#include <cmath>

namespace vdrive::ros2 {
namespace {

// [s of wall time]
constexpr double kAheadOnTrajectory = 0.15;  // outlasts a pause of the machine
constexpr double kAheadOnTrack = 0.015;      // a position that comes now is late by it
constexpr double kLongest = 0.128;           // after set-points that came too late

// In lock-step, where the program that steps has to know them beforehand: ticks between the newest
// state and the first set-point of a motion, and those that a step may have while it lasts.
constexpr std::uint64_t kLeadTicks = 20;
constexpr std::uint64_t kTrajectoryTicks = 100;
constexpr std::uint64_t kTrackTicks = 40;

// A bench keeps 1,024 frames of all its clients: two bridges and a tool have room.
constexpr double kMostAhead = 400.0;

}  // namespace

std::uint64_t SetPointLead::ticks(double seconds) const {
  return static_cast<std::uint64_t>(
      std::clamp(std::ceil(seconds * rate_ / period_), 1.0, kMostAhead));
}

std::uint64_t SetPointLead::lead() const {
  return clock_ == ClockMode::lockstep ? kLeadTicks : ticks(lead_);
}

std::uint64_t SetPointLead::window(bool is_trajectory) const {
  if (clock_ == ClockMode::lockstep) return is_trajectory ? kTrajectoryTicks : kTrackTicks;
  return ticks(std::max(is_trajectory ? kAheadOnTrajectory : kAheadOnTrack, 2.0 * lead_));
}

std::uint64_t SetPointLead::ahead_of_trajectory() const {
  return clock_ == ClockMode::lockstep ? kTrajectoryTicks / 2 : ticks(kAheadOnTrajectory);
}

void SetPointLead::lengthen() noexcept {
  lead_ = std::min(2.0 * lead_, kLongest);
}

}  // namespace vdrive::ros2
