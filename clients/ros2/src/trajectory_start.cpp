// SPDX-License-Identifier: Apache-2.0
#include "trajectory_start.hpp"

#include "ros_time.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace vdrive::ros2 {
namespace {

/// @param start its time [ns], 0 = at once
/// @param waits is set when that is later than what can be sent now
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
/// @param passed [s] of the trajectory that are over
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

}  // namespace

TrajectoryStart plan_start(const Trajectory& trajectory, const ServedBenches& benches,
                           double tolerance) {
  TrajectoryStart start;
  // All begins before the first path: on one bench that waits, the others wait too.
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

}  // namespace vdrive::ros2
