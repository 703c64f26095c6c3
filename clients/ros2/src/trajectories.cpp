// SPDX-License-Identifier: Apache-2.0
#include "trajectories.hpp"

#include "vdrive/number_text.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace vdrive::ros2 {
namespace {

using bridge::Severity;

constexpr double kNanosecond = 1e-9;

std::string joined(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;
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
    const std::string problem = order.problem(writer, stamp, benches.time_of(bench));
    if (!problem.empty()) return problem;
  }
  return {};
}

void Trajectories::note_enable(bool is_enabled) {
  stamps_.clear();
  if (!is_enabled) waiting_.clear();
}

void Trajectories::end_with(const BenchMotion& motion) {
  for (const auto& [number, text] : running_) {
    if (!motion.follows(number)) continue;
    break_off({{.number = number, .reason = motion.link().name() + " was restarted"}});
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
  const std::string stamp = stamp_problem(stamps_, writer, trajectory.start, benches_, benches);
  if (!stamp.empty()) return stamp;
  for (std::size_t i = 0; i < trajectory.joints.size(); ++i) {
    const JointPlace& joint = trajectory.joints[i];
    const std::string problem = benches_.at(joint.bench).motion->trajectory_obstacle(joint.place);
    if (!problem.empty()) return "joint " + trajectory.names[i] + " " + problem;
  }
  return {};
}

void Trajectories::take(const ros::JointTrajectory& message, const wire::WriterId& writer) {
  std::string problem;
  auto trajectory = read_trajectory(
      message,
      [this](const std::string& name) {
        return benches_.find_joint(name);
      },
      problem);
  if (trajectory) problem = problem_of(*trajectory, writer);
  if (!problem.empty()) {
    refuse(problem);
    return;
  }
  stamps_.note(writer, trajectory->start);
  Waiting waiting{.trajectory = std::move(*trajectory), .limits = {}};
  for (const JointPlace& joint : waiting.trajectory.joints) {
    if (waiting.limits.contains(joint.bench)) continue;
    waiting.limits[joint.bench] = benches_.at(joint.bench).link->request_limits();
  }
  waiting_.clear();  // a new trajectory takes the place of one that has not started
  waiting_.push_back(std::move(waiting));
}

bool Trajectories::has_limits(const Waiting& waiting) const {
  return std::ranges::all_of(waiting.limits, [this](const auto& entry) {
    const auto bench = benches_.all().find(entry.first);
    return bench == benches_.all().end() || bench->second.link->limits_read() >= entry.second;
  });
}

void Trajectories::start_due() {
  std::erase_if(waiting_, [this](Waiting& waiting) {
    return has_limits(waiting) && try_start(waiting);
  });
}

/// @return whether it has been started or refused.
bool Trajectories::try_start(Waiting& waiting) {
  const Trajectory& trajectory = waiting.trajectory;
  for (std::size_t i = 0; i < trajectory.joints.size(); ++i) {
    const auto known = benches_.find_joint(trajectory.names[i]);
    const std::string problem =
        known ? benches_.motion_of(known->place).trajectory_obstacle(known->place.place)
              : "is no longer present";
    if (problem.empty()) continue;
    refuse("joint " + trajectory.names[i] + " " + problem);
    return true;
  }
  // One that starts later is checked at once as well, from the present positions.
  Start start = prepare(trajectory);
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

/// @param passed [s] of the trajectory that are over in the tick of its begin, by bench
void Trajectories::find_begins(const Trajectory& trajectory, Start& start,
                               std::map<std::uint32_t, double>& passed) {
  for (const JointPlace& joint : trajectory.joints) {
    if (start.begins.contains(joint.bench)) continue;
    const ServedBench& bench = benches_.at(joint.bench);
    std::uint64_t begin = bench.motion->begin_tick();
    if (trajectory.start != 0) {
      const std::int64_t early = trajectory.start - stamp_of(*bench.info, begin);
      const double ticks = static_cast<double>(early) * kNanosecond / bench.link->period();
      const auto whole = static_cast<std::uint64_t>(std::max(0.0, std::round(ticks)));
      begin = bench.motion->begin_tick(begin + whole);
    }
    start.begins[joint.bench] = begin;
    passed[joint.bench] = 0.0;
    if (trajectory.start == 0) continue;
    const std::int64_t stamp = stamp_of(*bench.info, begin);
    const double late = static_cast<double>(stamp - trajectory.start) * kNanosecond;
    // A difference below half a tick is rounding.
    if (late < -0.5 * bench.link->period()) start.waits = true;
    passed[joint.bench] = std::max(0.0, late);
  }
}

Trajectories::Start Trajectories::prepare(const Trajectory& trajectory) {
  Start start;
  std::map<std::uint32_t, double> passed;
  find_begins(trajectory, start, passed);
  start.paths.resize(trajectory.joints.size());
  for (std::size_t i = 0; i < trajectory.joints.size() && start.problem.empty(); ++i) {
    add_path(trajectory, i, start.waits ? 0.0 : passed[trajectory.joints[i].bench], start);
  }
  const bool is_empty = std::ranges::none_of(start.paths, [](const auto& path) {
    return path != nullptr;
  });
  if (start.problem.empty() && is_empty) start.problem = "all its points are in the past";
  return start;
}

void Trajectories::add_path(const Trajectory& trajectory, std::size_t joint, double passed,
                            Start& start) {
  const JointPlace& place = trajectory.joints[joint];
  BenchMotion& motion = benches_.motion_of(place);
  const Joint& known = motion.link().joints()[place.place];
  const JointMotion now = motion.motion(place.place);
  const double shortest = 0.5 * motion.link().period();
  std::vector<PathPoint> points;
  points.reserve(trajectory.points.size());
  for (const TrajectoryPoint& point : trajectory.points) {
    PathPoint path_point{.time = point.time - passed, .position = point.positions[joint]};
    if (!point.velocities.empty()) path_point.velocity = point.velocities[joint];
    if (!point.accelerations.empty()) path_point.acceleration = point.accelerations[joint];
    const bool is_start = path_point.time < shortest;
    const double gap = std::abs(path_point.position - now.position);
    if (is_start && point.time < shortest && !start.waits && gap > start_tolerance_) {
      start.problem = "joint " + known.name + " is at " + text_of(now.position) +
                      ", its point at the start is " + text_of(path_point.position) + " " +
                      known.unit_name() + ": more than the start_tolerance of " +
                      text_of(start_tolerance_) + " away";
      return;
    }
    if (!is_start) points.push_back(path_point);
  }
  if (points.empty()) return;
  auto path = std::make_shared<const JointPath>(now, points);
  const auto limits = motion.link().limits();
  const auto broken = limits ? path->check((*limits)[place.place], known.unit_name())
                             : std::optional<std::string>("its limits are not known");
  if (broken) {
    start.problem = "joint " + known.name + ": " + *broken;
    return;
  }
  start.paths[joint] = std::move(path);
}

void Trajectories::begin(const Trajectory& trajectory, const Start& start) {
  const std::uint64_t number = ++last_number_;
  const std::string text = "number " + std::to_string(number) + " of " + joined(trajectory.names) +
                           ", " + std::to_string(trajectory.points.size()) + " points";
  std::set<std::uint64_t> replaced;
  for (const auto& known : running_) {
    const std::uint64_t old = known.first;
    const bool is_replaced = std::ranges::any_of(trajectory.joints, [&](const JointPlace& joint) {
      return benches_.motion_of(joint).trajectory_of(joint.place) == old;
    });
    if (is_replaced) replaced.insert(old);
  }
  for (std::size_t i = 0; i < trajectory.joints.size(); ++i) {
    if (start.paths[i] == nullptr) continue;
    const JointPlace& joint = trajectory.joints[i];
    benches_.motion_of(joint).follow(joint.place, start.paths[i], start.begins.at(joint.bench),
                                     number);
  }
  // Joints of a replaced trajectory that this one does not move come to rest.
  for (const std::uint64_t old : replaced) {
    for (auto& [bench_number, bench] : benches_.all()) bench.motion->brake(old);
    running_.erase(old);
  }
  running_[number] = text;
  reports_.report(Severity::info, "joint trajectory", text + ": starts");
}

void Trajectories::break_off(const std::vector<BrokenTrajectory>& broken) {
  for (const BrokenTrajectory& one : broken) {
    const auto known = running_.find(one.number);
    if (known == running_.end()) continue;
    reports_.report(Severity::error, "joint trajectory",
                    known->second + ": stopped, " + one.reason);
    running_.erase(known);
    for (auto& [number, bench] : benches_.all()) bench.motion->brake(one.number);
  }
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
