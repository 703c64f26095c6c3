// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "diagnosis/finding.hpp"
#include "diagnosis/ros_readings.hpp"
#include "language/global_options.hpp"

#include <vector>

namespace vdrive::tool {

/// Judges what was found of ROS 2: its environment here, and vdrive-ros2 in the domain.
[[nodiscard]] std::vector<Finding> check_ros(const RosReadings& readings,
                                             const GlobalOptions& options);

}  // namespace vdrive::tool
