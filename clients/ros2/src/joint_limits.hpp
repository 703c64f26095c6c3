// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdrive::client {
class Axis;
}

namespace vdrive::ros2 {

struct ServedJoint;

/// The limits of a joint, in rad or m and s. An unlimited value is infinite.
struct JointLimits {
  static constexpr double kNone = std::numeric_limits<double>::infinity();

  double lower = -kNone;            ///< 607Dh:1 if enabled by 3535h, within 607Bh
  double upper = kNone;             ///< 607Dh:2
  double velocity = kNone;          ///< the lower of 607Fh and 5E11h, which follows from 6080h
  double acceleration = kNone;      ///< 60C5h
  double deceleration = kNone;      ///< 60C6h
  double ramp = kNone;              ///< the lowest of 6083h, 6084h, 60C5h and 60C6h
  double effort = kNone;            ///< 6072h [N.m or N]
  double effort_per_mille = 0.001;  ///< [N.m or N] per 1 ‰ of the rated torque
  double effort_slope = kNone;      ///< 6087h [N.m/s or N/s]
};

/// The motion of a joint at one instant [rad or m, s].
struct JointMotion {
  double position = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
};

/// @return a readable number, such as "1.5" and "-0.0625".
[[nodiscard]] std::string text_of(double value);

/// Reads the limits of joints from their drives, waiting for the answers.
/// @param axes the axes of the joints, in their order
/// @return one per joint; nothing if one of them cannot be read
[[nodiscard]] std::optional<std::vector<JointLimits>> read_limits(
    std::span<const client::Axis> axes, std::span<const ServedJoint> joints);

}  // namespace vdrive::ros2
