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

/// The command of a JointState for one joint.
struct JointCommand {
  JointPlace joint;
  CommandInterface interface = CommandInterface::position;
  double value = 0.0;  ///< finite
};

/// The commands of a message, and the errors in it.
struct JointCommands {
  std::vector<JointCommand> commands;
  std::vector<std::string> problems;  ///< one sentence each, without a full stop
};

/// Finds a joint by its name at the time of the message. If there is none, `problem` receives the
/// reason: words that follow the name.
using FindJoint =
    std::function<std::optional<JointPlace>(const std::string& name, std::string& problem)>;

/// Reads the commands in a JointState. A value that is not finite is skipped: ros2_control sends
/// such values before its first command. An array that is shorter than `name` refers to the joints
/// to which the configuration assigns this interface, in order.
[[nodiscard]] JointCommands read_commands(const ros::JointState& message, const FindJoint& find);

struct TrajectoryPoint {
  double time = 0.0;  ///< [s] from the start
  std::vector<double> positions;
  std::vector<double> velocities;     ///< empty, or one per joint
  std::vector<double> accelerations;  ///< empty, or one per joint
};

/// A well-formed trajectory.
struct Trajectory {
  std::vector<JointPlace> joints;
  std::vector<std::string> names;  ///< of the joints
  std::vector<TrajectoryPoint> points;
  std::int64_t start = 0;  ///< [ns], 0 = immediately
};

/// @param problem receives the reason of a refusal
/// @return nothing if the trajectory is refused.
[[nodiscard]] std::optional<Trajectory> read_trajectory(const ros::JointTrajectory& message,
                                                        const FindJoint& find,
                                                        std::string& problem);

}  // namespace vdrive::ros2
