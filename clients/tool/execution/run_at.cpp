// SPDX-License-Identifier: Apache-2.0
#include "execution/run_at.hpp"

namespace vdrive::tool {

void RunAt::declare(Arguments& arguments, std::string& axis) {
  arguments.axis(axis);
  arguments.positional("VELOCITY", velocity, "60FFh [UU/s, or 180deg/s]", parse_velocity);
  arguments.option("--acceleration", "A", acceleration,
                   "6083h [UU/s2, or 900deg/s2]; keeps this value", parse_ramp);
  arguments.option("--deceleration", "D", deceleration,
                   "6084h [UU/s2, or 900deg/s2]; keeps this value", parse_ramp);
  arguments.take_over(take_over);
}

void RunAt::check_units(const AxisFinder& axes, const client::Axis& axis) const {
  static_cast<void>(axes.user_units(axis, velocity));
  static_cast<void>(axes.limit(axis, acceleration));
  static_cast<void>(axes.limit(axis, deceleration));
}

std::int32_t RunAt::velocity_of(const AxisFinder& axes, const client::Axis& axis) const {
  return static_cast<std::int32_t>(axes.user_units(axis, velocity));
}

client::VelocityOptions RunAt::options(const CommandContext& context, const client::Axis& axis,
                                       client::Until until) const {
  client::VelocityOptions options;
  options.acceleration = context.axes.limit(axis, acceleration);
  options.deceleration = context.axes.limit(axis, deceleration);
  options.call = context.call_options(until);
  return options;
}

}  // namespace vdrive::tool
