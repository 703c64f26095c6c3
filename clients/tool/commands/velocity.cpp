// SPDX-License-Identifier: Apache-2.0
#include "commands/velocity.hpp"

#include "execution/axis_report.hpp"
#include "execution/motion_end.hpp"

#include <utility>

namespace vdrive::tool {

void VelocityCommand::declare(Arguments& arguments) {
  run_at.declare(arguments, axis);
  arguments.no_wait(until);
}

void VelocityCommand::check_units(const CommandContext& context, const client::Axis& driven) const {
  run_at.check_units(context.axes, driven);
}

client::Outcome VelocityCommand::run(CommandContext& context) const {
  auto found = context.axes.axis_to_command(axis, run_at.take_over);
  if (!found) return found.outcome();
  const auto velocity = run_at.velocity_of(context.axes, *found);
  context.progress.axis(*found, context.axes.label_of(found->id()), "waiting for the velocity");
  client::Outcome reached = found->run_at(velocity, run_at.options(context, *found, until));
  reached = end_endless_motion(*found, std::move(reached), context);
  return report_axis(context, *found, {.command = "velocity", .outcome = std::move(reached)});
}

extern const CommandRow kVelocity =
    row_of<VelocityCommand>({.name = "velocity",
                             .group = CommandGroup::motion,
                             .summary = "Run at a velocity (mode 3) until another command; 0 stops",
                             .example = "velocity 1.1 180deg/s"});

}  // namespace vdrive::tool
