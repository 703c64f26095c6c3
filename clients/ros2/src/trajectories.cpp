// SPDX-License-Identifier: Apache-2.0
#include "trajectories.hpp"

#include "joint_path.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::ros2 {

/// The way in which a trajectory would start now.
struct TrajectoryStart {
  /// The start on one bench.
  struct Begin {
    std::uint64_t tick = 0;  ///< the paths start after it
    double passed = 0.0;     ///< [s] of the trajectory that have passed by then
  };

  std::vector<std::shared_ptr<const JointPath>> paths;  ///< one per joint; null if at its target
  std::map<std::uint32_t, Begin> begins;                ///< by bench
  std::string problem;                                  ///< why it cannot start; empty = it can
  bool waits = false;                                   ///< its time has not come yet
};

namespace {

using bridge::Severity;

std::string names_text(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;  // for a readable log line
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  return names.size() > kMost ? text + " and " + std::to_string(names.size() - kMost) + " more"
                              : text;
}

/// @param start time of the start [ns], 0 = immediately
/// @param waits is set if that time is later than the ticks for which set-points can be sent now
TrajectoryStart::Begin find_begin(std::int64_t start, BenchMotion& motion, bool& waits) {
  TrajectoryStart::Begin begin{.tick = motion.begin_tick()};
  if (start == 0) return begin;
  const client::BenchInfo& info = motion.bench().info();
  const double period = motion.bench().period();
  const std::int64_t early = start - stamp_of(info, begin.tick);
  const double ticks = static_cast<double>(early) * kSecondsPerNanosecond / period;
  const auto whole = static_cast<std::uint64_t>(std::max(0.0, std::round(ticks)));
  begin.tick = motion.begin_tick(begin.tick + whole);
  const std::int64_t stamp = stamp_of(info, begin.tick);
  const double late = static_cast<double>(stamp - start) * kSecondsPerNanosecond;
  // A difference below half a tick is rounding.
  if (late < -0.5 * period) waits = true;
  begin.passed = std::max(0.0, late);
  return begin;
}

/// Plans the path of one joint.
/// @param passed [s] of the trajectory that have passed
void add_path(const Trajectory& trajectory, std::size_t joint, BenchMotion& motion, double passed,
              double tolerance, TrajectoryStart& start) {
  const std::size_t place = trajectory.joints[joint].place;
  const ServedJoint& served = motion.bench().joints()[place];
  const JointMotion now = motion.motion(place);
  const double shortest = 0.5 * motion.bench().period();
  std::vector<PathPoint> points;
  points.reserve(trajectory.points.size());
  for (const TrajectoryPoint& point : trajectory.points) {
    PathPoint path_point{.time = point.time - passed, .position = point.positions[joint]};
    if (!point.velocities.empty()) path_point.velocity = point.velocities[joint];
    if (!point.accelerations.empty()) path_point.acceleration = point.accelerations[joint];
    const bool is_start = path_point.time < shortest;
    const double gap = std::abs(path_point.position - now.position);
    if (is_start && point.time < shortest && !start.waits && gap > tolerance) {
      start.problem = served.label() + " is at " + text_of(now.position) +
                      ", its point at the start is " + text_of(path_point.position) + " " +
                      served.unit_name() + ": more than the start_tolerance of " +
                      text_of(tolerance) + " away";
      return;
    }
    if (!is_start) points.push_back(path_point);
  }
  if (points.empty()) return;
  auto path = std::make_shared<const JointPath>(now, points);
  const auto limits = motion.bench().seen().limits;
  const auto broken = limits ? path->check((*limits)[place], served.unit_name())
                             : std::optional<std::string>("its limits are not known");
  if (broken) {
    start.problem = served.label() + ": " + *broken;
    return;
  }
  start.paths[joint] = std::move(path);
}

/// Plans the paths of a trajectory from the present positions of its joints, and checks them
/// against the limits. A trajectory that waits is planned from its first point on.
/// @param trajectory for which there is no obstacle_to()
/// @param tolerance [rad or m] between a joint and a point at the start
TrajectoryStart plan_start(const Trajectory& trajectory, const ServedBenches& benches,
                           double tolerance) {
  TrajectoryStart start;
  // Finds all starts before it plans a path: if one bench waits, the others wait too.
  for (const JointPlace& joint : trajectory.joints) {
    if (start.begins.contains(joint.bench)) continue;
    start.begins[joint.bench] =
        find_begin(trajectory.start, benches.motion_of(joint.bench), start.waits);
  }
  start.paths.resize(trajectory.joints.size());
  for (std::size_t i = 0; i < trajectory.joints.size() && start.problem.empty(); ++i) {
    const std::uint32_t bench = trajectory.joints[i].bench;
    const double passed = start.waits ? 0.0 : start.begins.at(bench).passed;
    add_path(trajectory, i, benches.motion_of(bench), passed, tolerance, start);
  }
  const bool is_empty = std::ranges::count(start.paths, nullptr) == std::ssize(start.paths);
  if (start.problem.empty() && is_empty) start.problem = "all its points are in the past";
  return start;
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

/// @return why it cannot start with one of its joints; empty if it can.
std::string Trajectories::obstacle_to(const Trajectory& trajectory) const {
  for (std::size_t i = 0; i < trajectory.joints.size(); ++i) {
    const JointPlace& joint = trajectory.joints[i];
    // While the trajectory waited, the bench of a joint may have gone, and the name may now belong
    // to a joint of another bench.
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
  // A new trajectory replaces one that has not started.
  waiting_ = Waiting{.trajectory = std::move(*trajectory), .limits = {}};
  // It is checked against limits read from now on: another program may have just changed them.
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
  // A trajectory that starts later is also checked immediately, from the present positions.
  const TrajectoryStart start = plan_start(trajectory, benches_, start_tolerance_);
  // Its joints may be moving differently by then: what is invalid now may be valid at the start.
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
  const std::string text = "number " + std::to_string(number) + " of " +
                           names_text(trajectory.names) + ", " +
                           std::to_string(trajectory.points.size()) + " points";
  std::set<std::uint64_t> replaced;
  for (const JointPlace& joint : trajectory.joints) {
    replaced.insert(benches_.motion_of(joint.bench).trajectory_of(joint.place));
  }
  // The replaced trajectories were looked up before, and brake afterwards: at any time each joint
  // follows either its old trajectory or the new one.
  for (std::size_t i = 0; i < trajectory.joints.size(); ++i) {
    if (start.paths[i] == nullptr) continue;
    const JointPlace& joint = trajectory.joints[i];
    benches_.motion_of(joint.bench)
        .follow(joint.place, start.paths[i], start.begins.at(joint.bench).tick, number);
  }
  // Joints of a replaced trajectory that are not part of this one come to rest.
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
    // Its joints on other benches brake too: a trajectory of two arms without one of them is a
    // different motion.
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
