// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joints.hpp"
#include "vdrive/wire/ros_types.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::ros2 {

/// What a JointState commands one joint.
struct JointCommand {
  JointPlace joint;
  CommandInterface interface = CommandInterface::position;
  double value = 0.0;  ///< finite
};

/// The commands of a message, and what is wrong with it.
struct JointCommands {
  std::vector<JointCommand> commands;
  std::vector<std::string> problems;  ///< a sentence each, without a full stop
};

/// Finds a joint by its name, as it is at the time of the message. Where there is none, `problem`
/// gets the reason: words that follow the name.
using FindJoint =
    std::function<std::optional<JointPlace>(const std::string& name, std::string& problem)>;

/// Reads a JointState that commands. A value that is not finite is skipped: ros2_control sends such
/// before its first command. An array that is shorter than `name` holds the joints that the
/// configuration gives this interface, in order.
[[nodiscard]] JointCommands read_commands(const ros::JointState& message, const FindJoint& find);

/// A point of a trajectory.
struct TrajectoryPoint {
  double time = 0.0;  ///< [s] from the start
  std::vector<double> positions;
  std::vector<double> velocities;     ///< empty, or one a joint
  std::vector<double> accelerations;  ///< empty, or one a joint
};

/// A trajectory that is well formed.
struct Trajectory {
  std::vector<JointPlace> joints;
  std::vector<std::string> names;  ///< of the joints
  std::vector<TrajectoryPoint> points;
  std::int64_t start = 0;  ///< [ns], 0 = at once
};

/// @param problem gets the reason of a refusal
/// @return nothing when the trajectory is refused.
[[nodiscard]] std::optional<Trajectory> read_trajectory(const ros::JointTrajectory& message,
                                                        const FindJoint& find,
                                                        std::string& problem);

}  // namespace vdrive::ros2
