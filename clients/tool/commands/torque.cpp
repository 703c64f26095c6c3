// SPDX-License-Identifier: Apache-2.0
#include "commands/torque.hpp"

#include "execution/axis_report.hpp"
#include "execution/command_context.hpp"
#include "execution/motion_end.hpp"
#include "language/arguments.hpp"
#include "values/units.hpp"

#include <utility>

namespace vdrive::tool {
namespace {

std::uint32_t parse_slope(const std::string& text) {
  return static_cast<std::uint32_t>(parse_value(text, DataType::unsigned32));
}

}  // namespace

void TorqueCommand::declare(Arguments& arguments) {
  arguments.axis(axis);
  arguments.positional("TORQUE", torque, "6071h [per mille of rated torque, or 10%]", parse_torque);
  arguments.option("--slope", "S", slope,
                   "6087h [per mille of rated torque a second]; keeps this value", parse_slope);
  arguments.no_wait(until);
  arguments.take_over(take_over);
}

client::Outcome TorqueCommand::run(CommandContext& context) const {
  auto found = context.axes.axis_to_command(axis, take_over);
  if (!found) return found.outcome();
  client::TorqueOptions options;
  options.slope = slope;
  options.call = context.call_options(until);
  context.progress.axis(*found, context.axes.label_of(found->id()), "waiting for the torque");
  client::Outcome applied = found->apply_torque(torque, options);
  applied = end_endless_motion(*found, std::move(applied), context);
  return report_axis(context, *found, {.command = "torque", .outcome = std::move(applied)});
}

extern const CommandRow kTorque =
    row_of<TorqueCommand>({.name = "torque",
                           .group = CommandGroup::motion,
                           .summary = "Apply a torque (mode 4) until another command; 0 ends it",
                           .example = "torque 1.1 10% --slope 500"});

}  // namespace vdrive::tool
