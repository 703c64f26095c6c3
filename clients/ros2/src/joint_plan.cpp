// SPDX-License-Identifier: Apache-2.0
#include "joint_plan.hpp"

#include "vdrive/assert.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace vdrive::ros2 {
namespace {

// The line to a value takes longer than the interval between values, so that a value that is late
// by this part of the interval does not stop the joint.
constexpr double kMargin = 0.5;
constexpr double kShortestMargin = 0.004;  // [s] delays within one machine

// Values further apart are single goals, not a stream: a line over that time would be slow where a
// user wants a fast motion.
constexpr double kLongestInterval = 0.1;  // [s]
constexpr double kFirstInterval = 0.01;   // [s] until a second value gives the interval

// One late command changes the interval by only a quarter of the delay: writers without real-time
// capability send unevenly.
constexpr double kShareOfNewest = 0.25;

// A set-point that is late again and again has another problem, which the operator must know about.
constexpr int kMostRepeats = 8;

/// @return `effort` in ‰ of the rated torque.
std::int16_t per_mille(const JointCycle& now, double effort) noexcept {
  return static_cast<std::int16_t>(std::lround(effort / now.limits.effort_per_mille));
}

}  // namespace

std::string_view to_string(JointTask task) noexcept {
  constexpr std::array<std::string_view, 7> kNames{"none",     "hold",   "track", "trajectory",
                                                   "velocity", "effort", "settle"};
  return kNames[static_cast<std::size_t>(task)];
}

OperatingMode JointPlan::mode() const noexcept {
  if (task_ == JointTask::velocity) return mode_of(CommandInterface::velocity);
  if (task_ == JointTask::effort) return mode_of(CommandInterface::effort);
  return mode_of(CommandInterface::position);
}

/// @return the value that the drive commands in this tick, from which a line of this task starts.
double JointPlan::value_of_drive(const JointCycle& now) const noexcept {
  return task_ == JointTask::effort ? now.axis.status.torque_demand * now.limits.effort_per_mille
                                    : now.demand().velocity;
}

bool JointPlan::moves_by_itself(const JointCycle& now) const noexcept {
  if (task_ == JointTask::hold || task_ == JointTask::track || task_ == JointTask::trajectory)
    return false;
  if (task_ == JointTask::effort || is_entering() || streams()) return true;
  // The last velocity is 0, but earlier ones may still be in flight.
  const bool is_under_way = ends_at_ != 0 && now.tick <= ends_at_;
  return is_under_way || now.axis.status.velocity_demand_value != 0;
}

JointMotion JointPlan::motion(const JointCycle& now, std::uint64_t tick) const {
  switch (task_) {
    case JointTask::hold:
      return {position_, 0.0, 0.0};
    case JointTask::track:
      return tracker_->now();
    case JointTask::trajectory:
      return path_->at(now.seconds(begin_, tick));
    default:
      return now.demand();
  }
}

// ---- commands --------------------------------------------------------------------------------

/// @return [s] since the previous command
double JointPlan::note_command(const JointCycle& now) {
  is_lost_ = false;
  return now.seconds(std::exchange(commanded_at_, now.tick), now.tick);
}

/// @return [s] that the line to a new value takes
double JointPlan::time_of_line(const JointCycle& now, double passed, bool begins) {
  if (begins || interval_ == 0.0) {
    interval_ = kFirstInterval;
  } else if (passed < kLongestInterval) {
    interval_ += kShareOfNewest * (std::max(passed, now.period) - interval_);
  }
  return interval_ + std::max(kShortestMargin, kMargin * interval_);
}

bool JointPlan::go_to(const JointCycle& now, double position) {
  const double passed = note_command(now);
  if (moves_by_itself(now)) {
    if (task_ != JointTask::settle) enter(JointTask::settle);
    value_ = position;
    return false;
  }
  if (task_ == JointTask::hold && position_ == position) return false;  // it is already there
  const bool begins = task_ != JointTask::track;
  if (begins) track(motion(now, now.tick), position);
  tracker().go_to(position, time_of_line(now, passed, begins));
  return begins;
}

bool JointPlan::run(const JointCycle& now, JointTask task, double value) {
  const double passed = note_command(now);
  if (task_ != task) enter(task);
  const double over = time_of_line(now, passed, is_entering());
  // If the value is the same as before, its line continues. If the drive should show it by now but
  // does not, it is written again: a limit switch may have held the drive back.
  const bool is_missed = !streams() && ends_at_ != 0 && now.tick > ends_at_;
  const bool is_new = value_ != value || is_missed;
  const double last = std::exchange(value_, value);
  return !is_entering() && is_new && lead_to_value(last, over);
}

/// A drive drops set-points for a mode that it is not in yet, so the first one waits.
void JointPlan::enter(JointTask task) {
  task_ = task;
  tracker_.reset();
  path_.reset();
  line_.reset();
  is_entered_ = false;
  sent_for_ = 0;
  enters_at_ = 0;
  ends_at_ = 0;
  repeats_ = 0;
}

/// @param last value sent, used if there is no line to continue
/// @return whether this starts a line
bool JointPlan::lead_to_value(double last, double over) {
  const bool begins = !line_.has_value();
  if (begins) line_.emplace(last);
  line().go_to(value_, over);
  ends_at_ = 0;
  return begins;
}

void JointPlan::lead_from_drive(const JointCycle& now) {
  line_.reset();
  lead_to_value(value_of_drive(now), kFirstInterval);
}

void JointPlan::follow(const JointCycle& now, std::shared_ptr<const JointPath> path,
                       std::uint64_t begin, std::uint64_t number) {
  ensure(path != nullptr, "a trajectory has the path of its joint");
  task_ = JointTask::trajectory;
  tracker_.reset();
  line_.reset();
  path_ = std::move(path);
  begin_ = begin;
  trajectory_ = number;
  commanded_at_ = now.tick;
}

void JointPlan::brake(const JointCycle& now, std::uint64_t tick) {
  tracker_.emplace(motion(now, tick));
  tracker_->stop(now.limits);
  task_ = JointTask::track;
  path_.reset();
}

bool JointPlan::brake_free() {
  if (!runs_freely()) return false;
  if (task_ == JointTask::effort) enter(JointTask::velocity);
  const double last = std::exchange(value_, 0.0);
  if (!is_entering()) lead_to_value(last, 0.0);
  return true;
}

JointTracker& JointPlan::tracker() {
  ensure(tracker_.has_value(), "a joint that tracks positions has its tracker");
  return *tracker_;
}

ValueLine& JointPlan::line() {
  ensure(line_.has_value(), "a joint on the way to a velocity or an effort has its line");
  return *line_;
}

void JointPlan::track(const JointMotion& start, double goal) {
  tracker_.emplace(start);
  tracker_->go_to(goal, kFirstInterval);
  line_.reset();
  task_ = JointTask::track;
}

// ---- each cycle ------------------------------------------------------------------------------

bool JointPlan::brake_without_command(const JointCycle& now, double timeout) {
  const bool is_fed =
      task_ == JointTask::track || task_ == JointTask::velocity || task_ == JointTask::effort;
  if (!is_fed || is_lost_ || now.seconds(commanded_at_, now.tick) <= timeout) return false;
  is_lost_ = true;
  if (task_ != JointTask::track) return brake_free();
  tracker().stop(now.limits);
  return true;
}

std::uint64_t JointPlan::start_again(const JointCycle& now) {
  const JointMotion rest{now.demand().position, 0.0, 0.0};  // the drive holds
  const std::uint64_t ended = trajectory();
  if (task_ == JointTask::track) track(rest, tracker().goal());
  if (is_free()) lead_from_drive(now);
  if (ended == 0) return 0;
  *this = {};
  task_ = JointTask::hold;
  position_ = rest.position;
  return ended;
}

/// @return whether the drive follows the last set-point.
bool JointPlan::is_at_end(const JointCycle& now) const noexcept {
  const AxisStatus& shown = now.axis.status;
  if (task_ == JointTask::velocity) return shown.velocity_demand_value == now.user_units(value_);
  // 6074h is the torque commanded by the drive, rounded.
  if (task_ == JointTask::effort)
    return std::abs(shown.torque_demand - per_mille(now, value_)) <= 1;
  return shown.position_demand_value == now.user_units(position_);
}

JointPlan::End JointPlan::check_end(const JointCycle& now) {
  if (streams() || ends_at_ == 0 || now.tick <= ends_at_) return End::open;
  const bool is_there = is_at_end(now);
  // During a stop, or at a limit of the drive such as its speed limit, the received value is not
  // visible.
  const bool is_held_back = is_free() && !now.axis.shows(Statusword::kFollowsCommand);
  if (!is_there && is_held_back) return End::open;
  ends_at_ = 0;
  if (!is_there && ++repeats_ <= kMostRepeats) return End::refused;
  repeats_ = 0;
  if (is_there) return End::reached;
  // Adopt the present value of the drive, so that the next command of the same value is a motion
  // again.
  if (is_free()) {
    value_ = value_of_drive(now);
  } else {
    position_ = now.demand().position;
  }
  return End::given_up;
}

void JointPlan::repeat_end(const JointCycle& now) {
  if (is_free()) {
    lead_from_drive(now);
    return;
  }
  track({now.demand().position, 0.0, 0.0}, position_);  // the drive holds
  commanded_at_ = now.tick;
}

/// A drive changes its mode at rest, and accepts set-points from then on.
bool JointPlan::settles(const JointCycle& now) {
  const bool has_mode = sent_for_ != 0 && now.tick >= enters_at_ && now.axis.mode() == mode();
  if (!is_entering() || !has_mode) return false;
  if (is_free()) {
    is_entered_ = true;
    lead_from_drive(now);
    return true;
  }
  if (now.axis.status.velocity_demand_value != 0) return false;
  track(now.demand(), value_);
  return true;
}

// ---- set-points ------------------------------------------------------------------------------

client::SetPoint JointPlan::next_point(const JointCycle& now, std::uint64_t tick) {
  const std::uint16_t axis = now.joint.axis.axis;
  client::SetPoint point =
      now.axis.mode() == mode() ? client::SetPoint{.axis = axis} : begin_stream(axis, mode());
  const bool ends = is_free() ? put_value(now, point) : put_position(now, tick, point);
  if (ends) {
    if (!is_free()) task_ = JointTask::hold;
    ends_at_ = tick;
    tracker_.reset();
    path_.reset();
    line_.reset();
  }
  return point;
}

/// @return whether this is the last position of the motion
bool JointPlan::put_position(const JointCycle& now, std::uint64_t tick, client::SetPoint& point) {
  bool ends = false;
  if (task_ == JointTask::track) {
    position_ = tracker().step(now.period, now.limits).position;
    ends = tracker().is_at_rest();
  } else {
    const double time = now.seconds(begin_, tick);
    position_ = path_->at(time).position;
    ends = time >= path_->duration();
  }
  point.position = now.user_units(position_);
  return ends;
}

/// @return whether this is the commanded value
bool JointPlan::put_value(const JointCycle& now, client::SetPoint& point) {
  const JointLimits& limits = now.limits;
  // The drive's own profiles also treat a ramp of 0 as 1, so that a joint can always be stopped.
  if (task_ == JointTask::velocity) {
    const double ramp = std::max(limits.ramp, now.joint.si_per_user_unit);
    point.velocity = now.user_units(line().step(now.period, ramp));
  } else {
    const double slope = std::max(limits.effort_slope, limits.effort_per_mille);
    point.torque = per_mille(now, line().step(now.period, slope));
  }
  return line().is_at_goal();
}

std::optional<client::SetPoint> JointPlan::mode_point(const JointCycle& now, std::uint64_t tick) {
  if (!is_entering() || now.tick <= sent_for_) return std::nullopt;
  // The drive shows this mode already, but an earlier set-point with another mode may be in flight.
  // So the mode counts only from the tick in which the new set-point acts.
  if (sent_for_ == 0 && now.axis.mode() == mode()) enters_at_ = tick;
  sent_for_ = tick;
  return begin_stream(now.joint.axis.axis, mode());
}

}  // namespace vdrive::ros2
