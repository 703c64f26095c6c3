// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench.hpp"
#include "joint_limits.hpp"
#include "joints.hpp"
#include "requests.hpp"
#include "vdrive/client/axis_snapshot.hpp"

#include <cstdint>
#include <string>

/// Why a command that arrives cannot be carried out: texts that go on behind the name of the
/// joint, empty where nothing is wrong.
namespace vdrive::ros2 {

/// @return what keeps `session` from commanding the axis.
/// @param has_limits whether those of its joint were read
/// @param names of other sessions, or nullptr
[[nodiscard]] std::string obstacle_of(const client::AxisSnapshot& axis, std::uint64_t session,
                                      bool has_limits, const Bench::Names* names);

/// @return which limit the value of a command breaks.
[[nodiscard]] std::string problem_of(const JointCommand& command, const ServedJoint& joint,
                                     const JointLimits& limits);

}  // namespace vdrive::ros2
