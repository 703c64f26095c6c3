// SPDX-License-Identifier: Apache-2.0
#include "bench_motion.hpp"

#include "vdrive/cia402/power_state.hpp"
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace vdrive::ros2 {

using bridge::Severity;

std::string obstacle_of(const client::AxisSnapshot& axis, std::uint64_t session, bool has_limits,
                        const Bench::Names* names) {
  if (axis.owner_session == 0) return "is not under control of this bridge yet";
  if (axis.owner_session != session) {
    return "is controlled by " + owner_text(axis.owner_session, names);
  }
  if (!has_limits) return "has limits that have not been read yet";
  if (axis.state() != PowerState::operation_enabled) return client::what_it_shows(axis);
  return {};
}

std::string problem_of(const JointCommand& command, const ServedJoint& joint,
                       const JointLimits& limits) {
  const std::string what = std::string(to_string(command.interface)) + " " + text_of(command.value);
  if (command.interface == CommandInterface::position) {
    if (command.value < limits.lower || command.value > limits.upper) {
      return what + " " + joint.unit_name() + " is beyond the limits " + text_of(limits.lower) +
             " to " + text_of(limits.upper);
    }
    return limits.ramp > 0.0 && limits.velocity > 0.0 ? ""
                                                      : "cannot move: a speed limit or ramp is 0";
  }
  const double limit =
      command.interface == CommandInterface::velocity ? limits.velocity : limits.effort;
  if (std::abs(command.value) <= limit) return {};
  return what + " is above the limit " + text_of(limit);
}

BenchMotion::BenchMotion(std::uint64_t session, Bench& bench, bridge::Reports& reports,
                         double command_timeout, Send send)
    : session_(session),
      bench_(bench),
      reports_(reports),
      command_timeout_(command_timeout),
      send_(std::move(send)),
      power_(session, bench, reports),
      plans_(bench.joints().size()),
      stream_(bench.info(), bench.period(), plans_),
      now_{.bench = bench} {}

bool BenchMotion::is_disabled() const {
  return !now_.seen.state || power_.is_disabled(*now_.seen.state);
}

/// @return why the joint cannot be commanded now; empty if it can.
std::string BenchMotion::obstacle(std::size_t place) const {
  if (!power_.wants_enabled()) {
    return "is not enabled: publish true on the topic enable, or use --enable";
  }
  if (!now_.seen.state) return "is on a bench that sends no status";
  return obstacle_of(now_.seen.state->axes[place], session_, now_.seen.limits != nullptr,
                     now_.seen.names.get());
}

std::string BenchMotion::trajectory_obstacle(std::size_t place) const {
  std::string problem = obstacle(place);
  if (problem.empty() && plans_[place].moves_by_itself(now_.joint(place))) {
    problem = "is moving: it must be at rest first";
  }
  return problem;
}

// ---- commands --------------------------------------------------------------------------------

void BenchMotion::command(const JointCommand& command) {
  const std::size_t place = command.joint.place;
  JointPlan& plan = plans_[place];
  std::string problem = obstacle(place);
  if (problem.empty() && plan.task() == JointTask::trajectory) problem = "follows a trajectory";
  if (problem.empty()) {
    problem = problem_of(command, bench_.joints()[place], (*now_.seen.limits)[place]);
  }
  if (!problem.empty()) {
    warn(place, problem + ": the command is ignored");
    return;
  }
  const JointCycle joint = now_.joint(place);
  const bool ran = stream_.is_running();
  const bool is_velocity = command.interface == CommandInterface::velocity;
  const bool begins =
      command.interface == CommandInterface::position
          ? plan.go_to(joint, command.value)
          : plan.run(joint, is_velocity ? JointTask::velocity : JointTask::effort, command.value);
  if (begins && !ran) stream_.begin(joint.tick);
}

void BenchMotion::stop_free_joints(const std::string& reason) {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    const bool ran = stream_.is_running();
    if (!plans_[i].brake_free()) continue;
    if (!ran && stream_.is_running()) stream_.begin(now_.tick());
    warn(i, reason + ": it brakes");
  }
}

std::uint64_t BenchMotion::begin_tick(std::uint64_t wanted) {
  if (!stream_.is_running()) stream_.begin(now_.tick(), wanted);
  return stream_.sent_until();
}

JointMotion BenchMotion::motion(std::size_t place) const {
  return plans_[place].motion(now_.joint(place), stream_.sent_until());
}

void BenchMotion::follow(std::size_t place, std::shared_ptr<const JointPath> path,
                         std::uint64_t begin, std::uint64_t number) {
  plans_[place].follow(now_.joint(place), std::move(path), begin, number);
}

void BenchMotion::brake(std::uint64_t number) {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (plans_[i].trajectory() != number || number == 0) continue;
    plans_[i].brake(now_.joint(i), stream_.sent_until());
  }
}

bool BenchMotion::follows(std::uint64_t number) const {
  return std::ranges::count(plans_, number, &JointPlan::trajectory) > 0;
}

std::vector<JointTask> BenchMotion::tasks() const {
  std::vector<JointTask> tasks(plans_.size());
  std::ranges::transform(plans_, tasks.begin(), &JointPlan::task);
  return tasks;
}

// ---- each cycle ------------------------------------------------------------------------------

BrokenTrajectories BenchMotion::update(Clock::time_point now) {
  BrokenTrajectories broken;
  const auto add = [&](const BrokenTrajectories& more) {
    broken.insert(broken.end(), more.begin(), more.end());
  };
  const Bench::State before = std::exchange(now_.seen, bench_.seen()).state;
  if (!now_.seen.state) {
    if (before) add(end_all(bench_.label() + " sends no status"));
    return broken;
  }
  // Another run of the service, or a snapshot: the ticks of the plans no longer match those of the
  // bench.
  if (before && now_.tick() < before->tick) {
    add(end_all(bench_.label() + " went back to a lower tick (restart or snapshot)"));
  }
  stream_.set_rate(now_.seen.rate);
  power_.report_faults(*now_.seen.state);
  // Power first, so that no set-point goes to a joint that is no longer enabled.
  if (const std::string problem = first_obstacle(); !problem.empty()) {
    const std::vector<std::size_t> running = free_joints();
    add(end_all(problem));
    brake_joints(running, problem);
  }
  send(power_.words(*now_.seen.state, now));
  check_commands();
  add(catch_up());
  check_ends();
  // A joint that is in its mode by now gets its first set-point in this cycle.
  send(stream_.modes(now_));
  send(stream_.points(now_));
  if (power_.is_keep_alive_due(*now_.seen.state)) send({client::SetPointFrame{}});
  return broken;
}

/// Ends all plans. Nothing is sent for this: the bench has dropped the set-points that were
/// waiting, or carries them out and then holds.
/// @return the trajectories that this ends.
BrokenTrajectories BenchMotion::end_all(const std::string& reason) {
  BrokenTrajectories broken;
  for (JointPlan& plan : plans_) {
    if (plan.trajectory() != 0) broken.push_back({.number = plan.trajectory(), .reason = reason});
    plan = {};
  }
  stream_.clear();
  return broken;
}

void BenchMotion::check_commands() {
  if (command_timeout_ <= 0.0) return;
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (plans_[i].task() == JointTask::none) continue;
    const bool ran = stream_.is_running();
    if (!plans_[i].brake_without_command(now_.joint(i), command_timeout_)) continue;
    if (!ran && stream_.is_running()) stream_.begin(now_.tick());
    warn(i, "no command for " + text_of(command_timeout_) + " s: it brakes");
  }
}

/// If a bench has run past the last set-point that it received, it holds there: new motion starts
/// from there.
BrokenTrajectories BenchMotion::catch_up() {
  BrokenTrajectories broken;
  if (!stream_.is_running() || now_.tick() <= stream_.sent_until()) return broken;
  const std::string reason = bench_.label() + " was " +
                             std::to_string(now_.tick() - stream_.sent_until()) +
                             " ticks ahead of its set-points";
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (!plans_[i].streams()) continue;
    const std::uint64_t number = plans_[i].start_again(now_.joint(i));
    if (number != 0) broken.push_back({.number = number, .reason = reason});
  }
  stream_.catch_up(now_.tick());
  return broken;
}

/// If the last set-points of a motion arrive too late, the bench refuses them and the drive stops
/// short of its goal: they are sent again.
void BenchMotion::check_ends() {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (plans_[i].task() == JointTask::none) continue;
    const JointCycle joint = now_.joint(i);
    const JointPlan::End end = plans_[i].check_end(joint);
    if (end == JointPlan::End::given_up) {
      warn(i, "the drive does not accept its last set-point");
    } else if (end == JointPlan::End::refused) {
      stream_.lengthen();
      if (!stream_.is_running()) stream_.begin(now_.tick());
      plans_[i].repeat_end(joint);
    }
  }
}

/// @return why a joint with a plan cannot be moved; empty if all can.
std::string BenchMotion::first_obstacle() const {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (plans_[i].task() == JointTask::none) continue;
    const std::string problem = power_.wants_enabled() ? obstacle(i) : "is disabled";
    if (!problem.empty()) return bench_.joints()[i].label() + " " + problem;
  }
  return {};
}

/// @return the joints moved by velocity or effort that can be commanded.
std::vector<std::size_t> BenchMotion::free_joints() const {
  std::vector<std::size_t> joints;
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    if (plans_[i].runs_freely() && obstacle(i).empty()) joints.push_back(i);
  }
  return joints;
}

/// Only for joints that are moved by velocity or effort: their last value would stay in force,
/// whereas a motion to a position ends without further commands.
void BenchMotion::brake_joints(const std::vector<std::size_t>& joints, const std::string& reason) {
  for (const std::size_t place : joints) {
    plans_[place].run(now_.joint(place), JointTask::velocity, 0.0);
    warn(place, reason + ": it brakes");
  }
}

void BenchMotion::send(const SetPointStream::Frames& frames) {
  if (frames.empty()) return;
  const client::Outcome sent = send_(frames);
  if (!sent) reports_.report(Severity::error, bench_.label(), sent.message());
}

void BenchMotion::warn(std::size_t place, const std::string& text) {
  reports_.report(Severity::warning, bench_.joints()[place].label(), text);
}

}  // namespace vdrive::ros2
