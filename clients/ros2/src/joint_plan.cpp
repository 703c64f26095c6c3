// SPDX-License-Identifier: Apache-2.0
#include "joint_plan.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace vdrive::ros2 {
namespace {

using namespace vdrive::literals;

constexpr OperatingMode kPositions = OperatingMode::cyclic_synchronous_position;

// The line to a position takes longer than the interval of positions: one that is late by this part
// of the interval does not stop the joint.
constexpr double kMargin = 0.5;
constexpr double kShortestMargin = 0.004;  // [s] the delays of one machine

// Positions that are further apart are single goals, not a stream: a line over such a time would
// be a slow motion where a person asks for a quick one.
constexpr double kLongestInterval = 0.1;  // [s]
constexpr double kFirstInterval = 0.01;   // [s] until a second position shows the interval

// One late command changes the line by a quarter: writers without a real-time system are uneven.
constexpr double kShareOfNewest = 0.25;

// A set-point that comes too late again and again is lost elsewhere: the operator has to know.
constexpr int kMostRepeats = 8;

constexpr ObjectAddress kInterpolationTime = describe("interpolation_time_period"_object).address;
constexpr ObjectAddress kPositionOffset = describe("position_offset"_object).address;
constexpr ObjectAddress kVelocityOffset = describe("velocity_offset"_object).address;
constexpr ObjectAddress kTorqueOffset = describe("torque_offset"_object).address;

/// A position for each tick follows: another master may have left another 60C2h, and offsets.
client::SetPoint begin_positions(std::uint16_t axis) {
  return {.axis = axis,
          .mode = kPositions,
          .objects = {{kInterpolationTime, 0},
                      {kPositionOffset, 0},
                      {kVelocityOffset, 0},
                      {kTorqueOffset, 0}}};
}

}  // namespace

std::string_view to_string(Duty duty) noexcept {
  constexpr std::array<std::string_view, 7> kNames{"none",     "hold",   "track", "trajectory",
                                                   "velocity", "effort", "settle"};
  return kNames[static_cast<std::size_t>(duty)];
}

bool JointPlan::moves_by_itself(const JointNow& now) const noexcept {
  if (duty_ == Duty::hold || has_positions()) return false;
  return duty_ == Duty::effort || duty_ == Duty::settle ||
         now.axis.status.velocity_demand_value != 0;
}

JointMotion JointPlan::motion(const JointNow& now, std::uint64_t tick) const {
  switch (duty_) {
    case Duty::hold:
      return {position_, 0.0, 0.0};
    case Duty::track:
      return tracker_->now();
    case Duty::trajectory:
      return path_->at(now.seconds(begin_, tick));
    default:
      return now.demand();
  }
}

// ---- commands --------------------------------------------------------------------------------

bool JointPlan::go_to(const JointNow& now, double position) {
  const double passed = now.seconds(std::exchange(commanded_at_, now.tick), now.tick);
  is_lost_ = false;
  if (moves_by_itself(now)) {
    if (duty_ != Duty::settle) sent_for_ = 0;
    duty_ = Duty::settle;
    value_ = position;
    return false;
  }
  if (duty_ == Duty::hold && position_ == position) return false;  // it is there
  const bool begins = duty_ != Duty::track;
  if (begins) {
    track(motion(now, now.tick), position);
    interval_ = 0.0;
  }
  if (!begins && passed < kLongestInterval) {
    interval_ += kShareOfNewest * (std::max(passed, now.period) - interval_);
  } else if (interval_ == 0.0) {
    interval_ = kFirstInterval;
  }
  tracker().go_to(position, interval_ + std::max(kShortestMargin, kMargin * interval_));
  return begins;
}

void JointPlan::run(const JointNow& now, Duty duty, double value) {
  is_lost_ = false;
  commanded_at_ = now.tick;
  set_free(duty, value);
}

void JointPlan::follow(const JointNow& now, std::shared_ptr<const JointPath> path,
                       std::uint64_t begin, std::uint64_t number) {
  ensure(path != nullptr, "a trajectory has the path of its joint");
  duty_ = Duty::trajectory;
  tracker_.reset();
  path_ = std::move(path);
  begin_ = begin;
  trajectory_ = number;
  commanded_at_ = now.tick;
}

void JointPlan::brake(const JointNow& now, std::uint64_t tick) {
  tracker_.emplace(motion(now, tick));
  tracker_->stop(now.limits);
  duty_ = Duty::track;
  path_.reset();
}

bool JointPlan::brake_free() {
  const bool moves = duty_ == Duty::effort || (duty_ == Duty::velocity && value_ != 0.0);
  if (moves) set_free(Duty::velocity, 0.0);
  return moves;
}

void JointPlan::set_free(Duty duty, double value) {
  is_due_ = is_due_ || duty_ != duty || value_ != value;
  duty_ = duty;
  value_ = value;
}

JointTracker& JointPlan::tracker() {
  ensure(tracker_.has_value(), "a joint that tracks positions has its tracker");
  return *tracker_;
}

void JointPlan::track(const JointMotion& start, double goal) {
  tracker_.emplace(start);
  tracker_->go_to(goal, kFirstInterval);
  duty_ = Duty::track;
}

// ---- each turn -------------------------------------------------------------------------------

bool JointPlan::brake_without_command(const JointNow& now, double timeout) {
  const bool is_fed = duty_ == Duty::track || duty_ == Duty::velocity || duty_ == Duty::effort;
  if (!is_fed || is_lost_ || now.seconds(commanded_at_, now.tick) <= timeout) return false;
  is_lost_ = true;
  if (duty_ != Duty::track) return brake_free();
  tracker().stop(now.limits);
  return true;
}

std::uint64_t JointPlan::start_again(const JointNow& now) {
  const JointMotion rest{now.demand().position, 0.0, 0.0};  // it holds
  const std::uint64_t ended = trajectory();
  if (duty_ == Duty::track) track(rest, tracker().goal());
  if (ended == 0) return 0;
  *this = {};
  duty_ = Duty::hold;
  position_ = rest.position;
  return ended;
}

JointPlan::End JointPlan::check_end(const JointNow& now) {
  if (duty_ != Duty::hold || ends_at_ == 0 || now.tick <= ends_at_) return End::open;
  ends_at_ = 0;
  const bool is_there = now.axis.status.position_demand_value == now.user_units(position_);
  if (!is_there && ++repeats_ <= kMostRepeats) return End::refused;
  repeats_ = 0;
  if (is_there) return End::reached;
  // It holds where the drive stands: the next command for the same position is a motion again.
  position_ = now.demand().position;
  return End::given_up;
}

void JointPlan::repeat_end(const JointNow& now) {
  track({now.demand().position, 0.0, 0.0}, position_);  // it holds
  commanded_at_ = now.tick;
}

/// A drive changes its mode at rest, and follows positions from then on.
bool JointPlan::settles(const JointNow& now) {
  const bool rests = now.axis.mode() == kPositions && now.axis.status.velocity_demand_value == 0;
  if (duty_ != Duty::settle || !rests) return false;
  track(now.demand(), value_);
  return true;
}

// ---- set-points ------------------------------------------------------------------------------

client::SetPoint JointPlan::position_point(const JointNow& now, std::uint64_t tick) {
  bool ends = false;
  if (duty_ == Duty::track) {
    position_ = tracker().step(now.period, now.limits).position;
    ends = tracker().is_at_rest();
  } else {
    const double time = now.seconds(begin_, tick);
    position_ = path_->at(time).position;
    ends = time >= path_->duration();
  }
  const std::uint16_t axis = now.joint.axis.axis;
  client::SetPoint point =
      now.axis.mode() == kPositions ? client::SetPoint{.axis = axis} : begin_positions(axis);
  point.position = now.user_units(position_);
  if (ends) {
    duty_ = Duty::hold;
    ends_at_ = tick;
    tracker_.reset();
    path_.reset();
  }
  return point;
}

std::optional<client::SetPoint> JointPlan::free_point(const JointNow& now, std::uint64_t tick) {
  const bool is_velocity = duty_ == Duty::velocity;
  if (!is_velocity && duty_ != Duty::effort) return std::nullopt;
  const OperatingMode mode =
      is_velocity ? OperatingMode::profile_velocity : OperatingMode::profile_torque;
  const bool is_missed = now.axis.mode() != mode && now.tick > sent_for_;
  if (!std::exchange(is_due_, false) && !is_missed) return std::nullopt;
  sent_for_ = tick;
  client::SetPoint point{.axis = now.joint.axis.axis, .mode = mode};
  if (is_velocity) {
    point.velocity = now.user_units(value_);
  } else {
    point.torque = static_cast<std::int16_t>(std::lround(value_ / now.limits.effort_per_mille));
  }
  return point;
}

std::optional<client::SetPoint> JointPlan::mode_point(const JointNow& now, std::uint64_t tick) {
  if (duty_ != Duty::settle || now.tick <= sent_for_) return std::nullopt;
  sent_for_ = tick;
  return begin_positions(now.joint.axis.axis);
}

}  // namespace vdrive::ros2
