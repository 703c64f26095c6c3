// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint_path.hpp"
#include "requests.hpp"
#include "served_benches.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::ros2 {

/// How a trajectory would start now.
struct TrajectoryStart {
  /// Where it starts on one bench.
  struct Begin {
    std::uint64_t tick = 0;  ///< behind it the paths begin
    double passed = 0.0;     ///< [s] of the trajectory that are over by then
  };

  std::vector<std::shared_ptr<const JointPath>> paths;  ///< one a joint; none for one at its target
  std::map<std::uint32_t, Begin> begins;                ///< by bench
  std::string problem;                                  ///< why it cannot; empty = it can
  bool waits = false;                                   ///< its time has not come
};

/// Plans the paths of a trajectory from where its joints are, and checks them against the limits.
/// One that waits is planned from its first point on.
/// @param trajectory whose joints can be commanded: without a trajectory_obstacle()
/// @param tolerance [rad or m] between a joint and a point at the start
[[nodiscard]] TrajectoryStart plan_start(const Trajectory& trajectory, const ServedBenches& benches,
                                         double tolerance);

}  // namespace vdrive::ros2
