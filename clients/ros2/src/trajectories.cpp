// SPDX-License-Identifier: Apache-2.0
#include "trajectories.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;

std::string joined(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;  // a line of a log for people
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  return names.size() > kMost ? text + " and " + std::to_string(names.size() - kMost) + " more"
                              : text;
}

}  // namespace

std::string stamp_problem(const StampOrder& order, const wire::WriterId& writer, std::int64_t stamp,
                          const ServedBenches& benches, const std::set<std::uint32_t>& numbers) {
  for (const std::uint32_t bench : numbers) {
    std::string problem = order.problem(writer, stamp, benches.time_of(bench));
    if (!problem.empty()) return problem;
  }
  return {};
}

void Trajectories::note_enable(bool is_enabled) {
  stamps_.clear();
  if (!is_enabled) waiting_.reset();
}

void Trajectories::end_with(BenchMotion& motion) {
  for (const auto& [number, text] : running_) {
    if (!motion.follows(number)) continue;
    break_off({{.number = number, .reason = motion.bench().label() + " was restarted"}});
    return;
  }
}

void Trajectories::refuse(const std::string& problem) {
  reports_.report(Severity::warning, "joint trajectory", "refused: " + problem);
}

std::string Trajectories::problem_of(const Trajectory& trajectory,
                                     const wire::WriterId& writer) const {
  std::set<std::uint32_t> benches;
  for (const JointPlace& joint : trajectory.joints) benches.insert(joint.bench);
  std::string stamp = stamp_problem(stamps_, writer, trajectory.start, benches_, benches);
  if (!stamp.empty()) return stamp;
  return obstacle_to(trajectory);
}

/// @return why it cannot start with one of its joints; empty when it can.
std::string Trajectories::obstacle_to(const Trajectory& trajectory) const {
  for (std::size_t i = 0; i < trajectory.joints.size(); ++i) {
    const JointPlace& joint = trajectory.joints[i];
    // While it waited its bench may have gone, and another one may have come with that name.
    const bool is_present = benches_.find_joint(trajectory.names[i]) == joint;
    const std::string problem =
        is_present ? benches_.motion_of(joint.bench).trajectory_obstacle(joint.place)
                   : "is no longer present";
    if (!problem.empty()) return "joint " + trajectory.names[i] + " " + problem;
  }
  return {};
}

void Trajectories::take(const ros::JointTrajectory& message, const wire::WriterId& writer) {
  std::string problem;
  auto trajectory = read_trajectory(
      message,
      [this](const std::string& name, std::string& unknown) {
        return benches_.find_joint(name, unknown);
      },
      problem);
  if (trajectory) problem = problem_of(*trajectory, writer);
  if (!problem.empty()) {
    refuse(problem);
    return;
  }
  stamps_.note(writer, trajectory->start);
  // A new trajectory takes the place of one that has not started.
  waiting_ = Waiting{.trajectory = std::move(*trajectory), .limits = {}};
  // It is checked against the limits of now: another program may have changed them just before.
  for (const JointPlace& joint : waiting_->trajectory.joints) {
    if (waiting_->limits.contains(joint.bench)) continue;
    waiting_->limits[joint.bench] = benches_.motion_of(joint.bench).bench().request_limits();
  }
}

bool Trajectories::has_limits(const Waiting& waiting) const {
  return std::ranges::all_of(waiting.limits, [this](const auto& entry) {
    const auto bench = benches_.all().find(entry.first);
    return bench == benches_.all().end() || bench->second.bench->seen().limits_read >= entry.second;
  });
}

void Trajectories::start_due() {
  if (waiting_ && has_limits(*waiting_) && try_start(*waiting_)) waiting_.reset();
}

/// @return whether it has been started or refused.
bool Trajectories::try_start(Waiting& waiting) {
  const Trajectory& trajectory = waiting.trajectory;
  if (const std::string problem = obstacle_to(trajectory); !problem.empty()) {
    refuse(problem);
    return true;
  }
  // One that starts later is checked at once as well, from the present positions.
  const TrajectoryStart start = plan_start(trajectory, benches_, start_tolerance_);
  // Later its joints may be on another way: what is wrong from there may be right at the start.
  if (start.waits && waiting.is_checked) return false;
  if (!start.problem.empty()) {
    refuse(start.problem);
    return true;
  }
  waiting.is_checked = true;
  if (start.waits) return false;
  begin(trajectory, start);
  return true;
}

void Trajectories::begin(const Trajectory& trajectory, const TrajectoryStart& start) {
  const std::uint64_t number = ++last_number_;
  const std::string text = "number " + std::to_string(number) + " of " + joined(trajectory.names) +
                           ", " + std::to_string(trajectory.points.size()) + " points";
  std::set<std::uint64_t> replaced;
  for (const JointPlace& joint : trajectory.joints) {
    replaced.insert(benches_.motion_of(joint.bench).trajectory_of(joint.place));
  }
  // After the search for what is replaced, before its joints brake: each joint has one of both.
  for (std::size_t i = 0; i < trajectory.joints.size(); ++i) {
    if (start.paths[i] == nullptr) continue;
    const JointPlace& joint = trajectory.joints[i];
    benches_.motion_of(joint.bench)
        .follow(joint.place, start.paths[i], start.begins.at(joint.bench).tick, number);
  }
  // Joints of a replaced trajectory that this one does not move come to rest.
  for (const std::uint64_t old : replaced) {
    if (running_.erase(old) > 0) brake_all(old);
  }
  running_[number] = text;
  reports_.report(Severity::info, "joint trajectory", text + ": starts");
}

void Trajectories::break_off(const BrokenTrajectories& broken) {
  for (const BrokenTrajectory& one : broken) {
    const auto known = running_.find(one.number);
    if (known == running_.end()) continue;
    reports_.report(Severity::error, "joint trajectory",
                    known->second + ": stopped, " + one.reason);
    running_.erase(known);
    // Also on other benches: a trajectory of two arms without one of them is another motion.
    brake_all(one.number);
  }
}

void Trajectories::brake_all(std::uint64_t number) {
  for (auto& [bench_number, bench] : benches_.all()) bench.motion->brake(number);
}

void Trajectories::forget_ended() {
  std::erase_if(running_, [this](const auto& trajectory) {
    const bool is_under_way = std::ranges::any_of(benches_.all(), [&](const auto& entry) {
      return entry.second.motion->follows(trajectory.first);
    });
    if (!is_under_way) {
      reports_.report(Severity::info, "joint trajectory", trajectory.second + ": set-points sent");
    }
    return !is_under_way;
  });
}

}  // namespace vdrive::ros2
