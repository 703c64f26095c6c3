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

/// What a joint may do, in rad or m and s. A value that is not limited is infinite.
struct JointLimits {
  static constexpr double kNone = std::numeric_limits<double>::infinity();

  double lower = -kNone;            ///< 607Dh:1 where 3535h switches it on, within 607Bh
  double upper = kNone;             ///< 607Dh:2
  double velocity = kNone;          ///< the lower one of 607Fh and 5E11h, which follows from 6080h
  double acceleration = kNone;      ///< 60C5h
  double deceleration = kNone;      ///< 60C6h
  double ramp = kNone;              ///< the lowest of 6083h, 6084h, 60C5h and 60C6h
  double effort = kNone;            ///< 6072h [N.m or N]
  double effort_per_mille = 0.001;  ///< [N.m or N] of 1 ‰ of the rated torque
  double effort_slope = kNone;      ///< 6087h [N.m/s or N/s]
};

/// A joint in one instant [rad or m, s].
struct JointMotion {
  double position = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
};

/// @return a number for people, such as "1.5" and "-0.0625".
[[nodiscard]] std::string text_of(double value);

/// Reads the limits of joints from their drives, and waits for them.
/// @param axes those of the joints, in their order
/// @return one a joint; none when one cannot be read
[[nodiscard]] std::optional<std::vector<JointLimits>> read_limits(
    std::span<const client::Axis> axes, std::span<const ServedJoint> joints);

}  // namespace vdrive::ros2
