// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joint_limits.hpp"
#include "joints.hpp"
#include "vdrive/client/axis.hpp"

#include <optional>
#include <span>
#include <vector>

namespace vdrive::ros2 {

/// Reads the limits of joints from their drives, and waits for them.
/// @param axes those of the joints, in their order
/// @return one a joint; none when one cannot be read
[[nodiscard]] std::optional<std::vector<JointLimits>> read_limits(
    std::span<const client::Axis> axes, std::span<const ServedJoint> joints);

}  // namespace vdrive::ros2
