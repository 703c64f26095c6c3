// SPDX-License-Identifier: Apache-2.0
#include "set_point_stream.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

namespace vdrive::ros2 {
namespace {

// [s of wall time]
constexpr double kAheadOnTrajectory = 0.15;  // outlasts a pause of the machine
constexpr double kAheadOnTrack = 0.015;      // a new position is delayed by this
constexpr double kLongest = 0.128;           // after late set-points

// In lock-step the stepping program must know these in advance: the ticks between the newest state
// and the first set-point of a motion, and the ticks that a step may have during a motion.
constexpr std::uint64_t kLeadTicks = 20;
constexpr std::uint64_t kTrajectoryTicks = 100;
constexpr std::uint64_t kTrackTicks = 40;

// A bench keeps 1,024 frames of all its clients: enough for two bridges and a tool.
constexpr double kMostAhead = 400.0;

using Frames = SetPointStream::Frames;

/// One frame with the result of `point` for each joint; none if there are no results.
template <typename Point>
Frames frame_of(std::uint64_t tick, std::size_t joints, const Point& point) {
  client::SetPointFrame frame{.tick = tick};
  for (std::size_t place = 0; place < joints; ++place) {
    if (auto one = point(place)) frame.axes.push_back(std::move(*one));
  }
  return frame.axes.empty() ? Frames{} : Frames{std::move(frame)};
}

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

bool SetPointStream::is_running() const {
  return std::ranges::any_of(plans_, &JointPlan::streams);
}

void SetPointStream::begin(std::uint64_t tick, std::uint64_t wanted) {
  sent_until_ = std::max(sent_until_, tick + lead_.lead() - 1);
  const bool is_near = wanted <= tick + lead_.ahead_of_trajectory();
  if (wanted > sent_until_ && is_near) sent_until_ = wanted;
}

void SetPointStream::catch_up(std::uint64_t tick) {
  lead_.lengthen();
  sent_until_ = tick + lead_.lead() - 1;
}

Frames SetPointStream::modes(const BenchCycle& now) {
  // Immediately, but after the set-points already sent in another mode.
  const std::uint64_t tick = sent_until_ > now.tick() ? sent_until_ + 1 : 0;
  const std::uint64_t reached = std::max(tick, now.tick() + lead_.lead());
  return frame_of(tick, plans_.size(), [&](std::size_t place) -> std::optional<client::SetPoint> {
    JointPlan& plan = plans_[place];
    if (!plan.is_entering()) return std::nullopt;
    const JointCycle joint = now.joint(place);
    const bool ran = is_running();
    if (!plan.settles(joint)) return plan.mode_point(joint, reached);
    if (!ran) begin(now.tick());
    return std::nullopt;
  });
}

Frames SetPointStream::points(const BenchCycle& now) {
  const bool has_trajectory =
      std::ranges::count(plans_, JointTask::trajectory, &JointPlan::task) > 0;
  const std::uint64_t last = now.tick() + lead_.window(has_trajectory);
  Frames frames;
  while (is_running() && sent_until_ < last) {
    ++sent_until_;
    client::SetPointFrame frame{.tick = sent_until_};
    for (std::size_t place = 0; place < plans_.size(); ++place) {
      if (!plans_[place].streams()) continue;
      frame.axes.push_back(plans_[place].next_point(now.joint(place), sent_until_));
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace vdrive::ros2
