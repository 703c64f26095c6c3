// SPDX-License-Identifier: Apache-2.0
#include "motion_check.hpp"

#include "vdrive/cia402/power_state.hpp"
#include "vdrive/number_text.hpp"

#include <cmath>

namespace vdrive::ros2 {

std::string obstacle_of(const client::AxisSnapshot& axis, std::uint64_t session, bool has_limits,
                        const Bench::Names* names) {
  if (axis.owner_session == 0) return "is not under control of this bridge yet";
  if (axis.owner_session != session) {
    return "is controlled by " + owner_text(axis.owner_session, names);
  }
  if (!has_limits) return "has limits that are not known yet";
  if (axis.state() != PowerState::operation_enabled) return client::what_it_shows(axis);
  return {};
}

std::string problem_of(const JointCommand& command, const ServedJoint& joint,
                       const JointLimits& limits) {
  const std::string what = std::string(to_string(command.interface)) + " " + text_of(command.value);
  if (command.interface == CommandInterface::position) {
    if (command.value < limits.lower || command.value > limits.upper) {
      return what + " " + joint.unit_name() + " is beyond the limits " + text_of(limits.lower) +
             " to " + text_of(limits.upper);
    }
    return limits.ramp > 0.0 && limits.velocity > 0.0
               ? ""
               : "has a limit of speed or a ramp of 0, which allows no motion";
  }
  const double limit =
      command.interface == CommandInterface::velocity ? limits.velocity : limits.effort;
  if (std::abs(command.value) <= limit) return {};
  return what + " is above the limit " + text_of(limit);
}

}  // namespace vdrive::ros2
