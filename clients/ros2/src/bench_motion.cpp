// SPDX-License-Identifier: Apache-2.0
#include "bench_motion.hpp"

#include "vdrive/cia402/power_state.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;

// The line to a position takes longer than the interval of positions: one that is late by this part
// of the interval does not stop the joint.
constexpr double kMargin = 0.5;
constexpr double kShortestMargin = 0.004;  // [s]
constexpr double kLongestInterval = 0.1;
constexpr double kFirstInterval = 0.01;

}  // namespace

std::string_view to_string(Duty duty) noexcept {
  constexpr std::array<std::string_view, 7> kNames{"none",     "hold",   "track", "trajectory",
                                                   "velocity", "effort", "settle"};
  return kNames[static_cast<std::size_t>(duty)];
}

BenchMotion::BenchMotion(client::Session& session, BenchLink& link, bridge::Reports& reports,
                         double command_timeout)
    : session_(session),
      link_(link),
      reports_(reports),
      command_timeout_(command_timeout),
      power_(session.id(), link, reports),
      lead_(link.info().clock_mode, link.period()),
      plans_(link.joints().size()) {}

// ---- time ------------------------------------------------------------------------------------

bool BenchMotion::is_on_trajectory() const {
  return std::ranges::any_of(plans_, [](const Plan& plan) {
    return plan.duty == Duty::trajectory;
  });
}

bool BenchMotion::positions_are_due() const {
  return std::ranges::any_of(plans_, [](const Plan& plan) {
    return plan.duty == Duty::track || plan.duty == Duty::trajectory;
  });
}

std::uint64_t BenchMotion::begin_tick(std::uint64_t wanted) {
  if (positions_are_due()) return sent_until_;
  sent_until_ = std::max(sent_until_, state_->tick + lead_.lead() - 1);
  const std::uint64_t ahead = lead_.ahead_of_trajectory();
  if (wanted > sent_until_ && wanted <= state_->tick + ahead) sent_until_ = wanted;
  return sent_until_;
}

// ---- power -----------------------------------------------------------------------------------

bool BenchMotion::is_disabled() const {
  return !state_ || power_.is_disabled(*state_);
}

std::string BenchMotion::obstacle(std::size_t place) const {
  if (!wants_enabled()) return "is not enabled: publish true on the topic enable, or use --enable";
  if (!state_) return "is on a bench that sends no status";
  const client::AxisSnapshot& axis = state_->axes[place];
  if (axis.owner_session == 0) return "is not under control of this bridge yet";
  if (axis.owner_session != session_.id()) {
    return "is controlled by session " + session_text(axis.owner_session);
  }
  if (!limits_) return "has limits that are not known yet";
  if (axis.state() != PowerState::operation_enabled) return client::what_it_shows(axis);
  return {};
}

/// @return whether the drive moves, or may move, by another cause than a stream of positions.
bool BenchMotion::moves_by_itself(std::size_t place) const {
  const Duty duty = plans_[place].duty;
  if (duty == Duty::hold || duty == Duty::track || duty == Duty::trajectory) return false;
  return duty == Duty::effort || duty == Duty::settle ||
         state_->axes[place].status.velocity_demand_value != 0;
}

std::string BenchMotion::trajectory_obstacle(std::size_t place) const {
  std::string problem = obstacle(place);
  if (problem.empty() && moves_by_itself(place)) problem = "moves: it has to rest first";
  return problem;
}

// ---- commands --------------------------------------------------------------------------------

std::int32_t BenchMotion::user_units(std::size_t place, double value) const {
  return static_cast<std::int32_t>(std::llround(value / link_.joints()[place].si_per_user_unit));
}

JointMotion BenchMotion::demand(std::size_t place) const {
  const double unit = link_.joints()[place].si_per_user_unit;
  const AxisStatus& status = state_->axes[place].status;
  return {status.position_demand_value * unit, status.velocity_demand_value * unit, 0.0};
}

JointMotion BenchMotion::motion(std::size_t place) const {
  const Plan& plan = plans_[place];
  switch (plan.duty) {
    case Duty::hold:
      return {plan.position, 0.0, 0.0};
    case Duty::track:
      return plan.tracker->now();
    case Duty::trajectory: {
      const double ticks = static_cast<double>(sent_until_) - static_cast<double>(plan.begin);
      return plan.path->at(ticks * link_.period());
    }
    default:
      return demand(place);
  }
}

std::string BenchMotion::check_value(std::size_t place, const JointCommand& command) const {
  const JointLimits& limits = (*limits_)[place];
  const Joint& joint = link_.joints()[place];
  const std::string what = std::string(to_string(command.interface)) + " " +
                           text_of(command.value) + " " + joint.unit_name();
  if (command.interface == Interface::position) {
    if (command.value < limits.lower || command.value > limits.upper) {
      return what + " is beyond the limits " + text_of(limits.lower) + " to " +
             text_of(limits.upper);
    }
    return limits.ramp > 0.0 && limits.velocity > 0.0
               ? ""
               : "has a limit of speed or a ramp of 0, which allows no motion";
  }
  const bool is_velocity = command.interface == Interface::velocity;
  const double limit = is_velocity ? limits.velocity : limits.effort;
  if (std::abs(command.value) <= limit) return {};
  return std::string(to_string(command.interface)) + " " + text_of(command.value) +
         " is above the limit " + text_of(limit);
}

void BenchMotion::command(const JointCommand& command) {
  const std::size_t place = command.joint.place;
  Plan& plan = plans_[place];
  std::string problem = obstacle(place);
  if (problem.empty() && plan.duty == Duty::trajectory) problem = "follows a trajectory";
  if (problem.empty()) problem = check_value(place, command);
  if (!problem.empty()) {
    reports_.report(Severity::warning, name_of(place), problem + ": the command is ignored");
    return;
  }
  plan.is_lost = false;
  switch (command.interface) {
    case Interface::position:
      track(place, command);
      break;
    case Interface::velocity:
      set_free(place, Duty::velocity, command.value);
      break;
    case Interface::effort:
      set_free(place, Duty::effort, command.value);
      break;
  }
  plan.commanded_at = state_->tick;
}

void BenchMotion::track(std::size_t place, const JointCommand& command) {
  Plan& plan = plans_[place];
  if (moves_by_itself(place)) {
    if (plan.duty != Duty::settle) plan.sent_for = 0;
    plan.duty = Duty::settle;
    plan.value = command.value;
    return;
  }
  double passed = kLongestInterval;
  if (plan.duty == Duty::track) {
    passed = static_cast<double>(state_->tick - plan.commanded_at) * link_.period();
  } else {
    if (plan.duty == Duty::hold && plan.position == command.value) return;  // it is there
    start_tracking(place, command.value);
    plan.interval = 0.0;
  }
  if (passed < kLongestInterval) {
    constexpr double kShare = 0.25;
    plan.interval += kShare * (std::max(passed, link_.period()) - plan.interval);
  } else if (plan.interval == 0.0) {
    plan.interval = kFirstInterval;
  }
  plan.tracker->go_to(command.value,
                      plan.interval + std::max(kShortestMargin, kMargin * plan.interval));
}

void BenchMotion::start_tracking(std::size_t place, double goal) {
  Plan& plan = plans_[place];
  (void)begin_tick();
  plan.tracker.emplace(motion(place));
  plan.tracker->go_to(goal, kFirstInterval);
  plan.duty = Duty::track;
}

/// A drive changes its mode at rest, and follows positions from then on.
void BenchMotion::settle() {
  constexpr OperatingMode kMode = OperatingMode::cyclic_synchronous_position;
  client::SetPointFrame frame;
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    Plan& plan = plans_[i];
    if (plan.duty != Duty::settle) continue;
    const client::AxisSnapshot& axis = state_->axes[i];
    if (axis.mode() == kMode && axis.status.velocity_demand_value == 0) {
      plan.duty = Duty::none;
      start_tracking(i, plan.value);
    } else if (state_->tick > plan.sent_for) {
      plan.sent_for = state_->tick + lead_.lead();
      frame.axes.push_back({.axis = axis_number(i), .mode = kMode});
    }
  }
  if (!frame.axes.empty()) (void)send({frame});
}

void BenchMotion::set_free(std::size_t place, Duty duty, double value) {
  Plan& plan = plans_[place];
  const bool changes = plan.duty != duty;
  plan.is_due = plan.is_due || changes || plan.value != value;
  plan.duty = duty;
  plan.value = value;
}

void BenchMotion::stop_free_joints(const std::string& reason) {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    const Plan& plan = plans_[i];
    const bool moves =
        plan.duty == Duty::effort || (plan.duty == Duty::velocity && plan.value != 0.0);
    if (!moves) continue;
    reports_.report(Severity::warning, name_of(i), reason + ": it brakes");
    set_free(i, Duty::velocity, 0.0);
  }
}

void BenchMotion::follow(std::size_t place, std::shared_ptr<const JointPath> path,
                         std::uint64_t begin, std::uint64_t number) {
  Plan& plan = plans_[place];
  plan.duty = Duty::trajectory;
  plan.tracker.reset();
  plan.path = std::move(path);
  plan.begin = begin;
  plan.trajectory = number;
  plan.commanded_at = state_->tick;
}

void BenchMotion::brake(std::uint64_t number) {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    Plan& plan = plans_[i];
    if (plan.duty != Duty::trajectory || plan.trajectory != number || !state_ || !limits_) continue;
    plan.tracker.emplace(motion(i));
    plan.tracker->stop((*limits_)[i]);
    plan.duty = Duty::track;
    plan.path.reset();
  }
}

bool BenchMotion::follows(std::uint64_t number) const {
  return std::ranges::any_of(plans_, [number](const Plan& plan) {
    return plan.duty == Duty::trajectory && plan.trajectory == number;
  });
}

// ---- each turn -------------------------------------------------------------------------------

std::vector<BrokenTrajectory> BenchMotion::update(Clock::time_point now) {
  std::vector<BrokenTrajectory> broken;
  auto newest = link_.state();
  if (!newest) {
    if (state_) drop_plans(link_.name() + " sends no status", broken);
    state_.reset();
    return broken;
  }
  if (state_ && newest->tick < state_->tick)
    drop_plans(link_.name() + " counts ticks from a lower number", broken);
  state_ = std::move(newest);
  limits_ = link_.limits();
  lead_.set_rate(link_.rate());
  power_.report_faults(*state_);
  check_enabled(broken);
  (void)send(power_.words(*state_, now));
  check_timeouts();
  catch_up(broken);
  repeat_refused_ends();
  settle();
  send_positions();
  send_free();
  if (power_.is_keep_alive_due(*state_)) (void)send({client::SetPointFrame{}});
  return broken;
}

/// The bench has dropped the waiting set-points, or holds where they end.
void BenchMotion::drop_plans(const std::string& reason, std::vector<BrokenTrajectory>& broken) {
  for (Plan& plan : plans_) {
    if (plan.duty == Duty::trajectory) {
      broken.push_back({.number = plan.trajectory, .reason = reason});
    }
    plan = {};
  }
  sent_until_ = 0;
}

void BenchMotion::check_enabled(std::vector<BrokenTrajectory>& broken) {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (plans_[i].duty == Duty::none) continue;
    const std::string problem = wants_enabled() ? obstacle(i) : "is disabled";
    if (problem.empty()) continue;
    drop_plans(name_of(i) + " " + problem, broken);
    return;
  }
}

void BenchMotion::check_timeouts() {
  if (command_timeout_ <= 0.0) return;
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    Plan& plan = plans_[i];
    const bool is_fed =
        plan.duty == Duty::track || plan.duty == Duty::velocity || plan.duty == Duty::effort;
    const double passed = static_cast<double>(state_->tick - plan.commanded_at) * link_.period();
    if (!is_fed || plan.is_lost || passed <= command_timeout_) continue;
    const bool rests = plan.duty == Duty::velocity && plan.value == 0.0;
    if (!rests) {
      reports_.report(Severity::warning, name_of(i),
                      "no command for " + text_of(command_timeout_) + " s: it brakes");
    }
    if (plan.duty == Duty::track) {
      plan.tracker->stop((*limits_)[i]);
    } else {
      set_free(i, Duty::velocity, 0.0);
    }
    plan.is_lost = true;
  }
}

/// A bench that has passed the last set-point that it received holds: what follows starts there.
void BenchMotion::catch_up(std::vector<BrokenTrajectory>& broken) {
  if (!positions_are_due() || state_->tick <= sent_until_) return;
  const std::string reason = link_.name() + " was " + std::to_string(state_->tick - sent_until_) +
                             " ticks ahead of its set-points";
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    Plan& plan = plans_[i];
    if (plan.duty == Duty::trajectory) {
      broken.push_back({.number = plan.trajectory, .reason = reason});
      plan = {.duty = Duty::hold, .position = demand(i).position};
    } else if (plan.duty == Duty::track) {
      const double goal = plan.tracker->goal();
      plan.tracker.emplace(JointMotion{demand(i).position, 0.0, 0.0});  // it holds
      plan.tracker->go_to(goal, kFirstInterval);
    }
  }
  lead_.lengthen();
  sent_until_ = state_->tick + lead_.lead() - 1;
}

/// A bench that is late to receive the last set-points of a motion refuses them, and the drive
/// holds before its goal: it gets them again.
void BenchMotion::repeat_refused_ends() {
  constexpr int kMostRepeats = 8;
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    Plan& plan = plans_[i];
    const bool is_to_be_checked =
        plan.duty == Duty::hold && plan.ends_at != 0 && state_->tick > plan.ends_at;
    if (!is_to_be_checked) continue;
    plan.ends_at = 0;
    const AxisStatus& status = state_->axes[i].status;
    if (status.position_demand_value == user_units(i, plan.position)) {
      plan.repeats = 0;
    } else if (++plan.repeats > kMostRepeats) {
      reports_.report(Severity::warning, name_of(i), "the drive does not take its last set-point");
      plan.repeats = 0;
    } else {
      lead_.lengthen();
      (void)begin_tick();
      plan.tracker.emplace(JointMotion{demand(i).position, 0.0, 0.0});  // it holds
      plan.tracker->go_to(plan.position, kFirstInterval);
      plan.duty = Duty::track;
      plan.commanded_at = state_->tick;
    }
  }
}

void BenchMotion::add_point(std::size_t place, std::uint64_t tick, client::SetPointFrame& frame) {
  Plan& plan = plans_[place];
  client::SetPoint point{.axis = axis_number(place)};
  bool ends = false;
  if (plan.duty == Duty::track) {
    plan.position = plan.tracker->step(link_.period(), (*limits_)[place]).position;
    ends = plan.tracker->is_at_rest();
  } else {
    const double time =
        (static_cast<double>(tick) - static_cast<double>(plan.begin)) * link_.period();
    plan.position = plan.path->at(time).position;
    ends = time >= plan.path->duration();
  }
  point.position = user_units(place, plan.position);
  if (state_->axes[place].mode() != OperatingMode::cyclic_synchronous_position) {
    point.mode = OperatingMode::cyclic_synchronous_position;
  }
  frame.axes.push_back(point);
  if (!ends) return;
  plan.duty = Duty::hold;
  plan.ends_at = tick;
  plan.tracker.reset();
  plan.path.reset();
}

void BenchMotion::send_positions() {
  std::vector<client::SetPointFrame> frames;
  const std::uint64_t last = state_->tick + lead_.window(is_on_trajectory());
  while (positions_are_due() && sent_until_ < last) {
    ++sent_until_;
    client::SetPointFrame frame{.tick = sent_until_};
    for (std::size_t i = 0; i < plans_.size(); ++i) {
      const Duty duty = plans_[i].duty;
      if (duty == Duty::track || duty == Duty::trajectory) add_point(i, sent_until_, frame);
    }
    frames.push_back(std::move(frame));
  }
  (void)send(frames);
}

/// Velocities and torques act at once, but after positions that were sent before.
void BenchMotion::send_free() {
  client::SetPointFrame frame{.tick = sent_until_ > state_->tick ? sent_until_ + 1 : 0};
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    Plan& plan = plans_[i];
    const bool is_velocity = plan.duty == Duty::velocity;
    if (!is_velocity && plan.duty != Duty::effort) continue;
    const OperatingMode mode =
        is_velocity ? OperatingMode::profile_velocity : OperatingMode::profile_torque;
    const bool is_missed = state_->axes[i].mode() != mode && state_->tick > plan.sent_for;
    if (!std::exchange(plan.is_due, false) && !is_missed) continue;
    plan.sent_for = std::max(frame.tick, state_->tick + lead_.lead());
    client::SetPoint point{.axis = axis_number(i), .mode = mode};
    if (is_velocity) {
      point.velocity = user_units(i, plan.value);
    } else {
      point.torque =
          static_cast<std::int16_t>(std::lround(plan.value / (*limits_)[i].effort_per_mille));
    }
    frame.axes.push_back(point);
  }
  if (!frame.axes.empty()) (void)send({frame});
}

bool BenchMotion::send(const std::vector<client::SetPointFrame>& frames) {
  if (frames.empty()) return true;
  const client::Outcome sent = session_.send_set_points(link_.info().number, frames);
  if (!sent) reports_.report(Severity::error, link_.name(), sent.message());
  return static_cast<bool>(sent);
}

std::vector<Duty> BenchMotion::duties() const {
  std::vector<Duty> duties;
  duties.reserve(plans_.size());
  for (const Plan& plan : plans_) duties.push_back(plan.duty);
  return duties;
}

bool BenchMotion::is_busy() const {
  return positions_are_due();
}

}  // namespace vdrive::ros2
