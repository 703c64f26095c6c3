// SPDX-License-Identifier: Apache-2.0
#include "commands/home.hpp"

#include "execution/axis_report.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "vdrive/cia402/homing_method.hpp"

#include <vector>

namespace vdrive::tool {
namespace {

std::int8_t parse_method(const std::string& text) {
  return static_cast<std::int8_t>(parse_value(text, DataType::integer8));
}

std::string help_of_methods() {
  std::string help = "6098h, how home is found:";
  for (const HomingMethodRow& row : kHomingMethods) {
    help.append("\n").append(std::to_string(row.number)).append(": ").append(row.what);
  }
  return help;
}

client::HomingOptions homing_options(const HomeCommand& command, const client::Axis& axis,
                                     const CommandContext& context) {
  const AxisFinder& axes = context.axes;
  client::HomingOptions options;
  options.method = command.method;
  if (command.offset) {
    options.offset = static_cast<std::int32_t>(axes.user_units(axis, *command.offset));
  }
  options.search_speed = axes.limit(axis, command.search_speed);
  options.creep_speed = axes.limit(axis, command.creep_speed);
  options.acceleration = axes.limit(axis, command.acceleration);
  options.call = context.call_options(command.until);
  return options;
}

}  // namespace

void HomeCommand::declare(Arguments& arguments) {
  arguments.axis(axis);
  arguments.option("--method", "M", method, help_of_methods(), parse_method)
      .completed_by([](auto, const BenchNames&) {
        std::vector<std::string> numbers;
        numbers.reserve(kHomingMethods.size());
        for (const HomingMethodRow& row : kHomingMethods) {
          numbers.push_back(std::to_string(row.number));
        }
        return numbers;
      });
  arguments.option("--offset", "P", offset, "607Ch: the position of home [UU, or 90deg]",
                   parse_position);
  arguments.option("--speed", "V", search_speed, "6099h:1 towards the switch [UU/s, or 90deg/s]",
                   parse_speed);
  arguments.option("--creep", "V", creep_speed, "6099h:2 towards home [UU/s, or 9deg/s]",
                   parse_speed);
  arguments.option("--acceleration", "A", acceleration, "609Ah [UU/s2, or 900deg/s2]", parse_ramp);
  arguments.no_wait(until);
  arguments.take_over(take_over);
}

void HomeCommand::check_units(const CommandContext& context, const client::Axis& homed) const {
  static_cast<void>(homing_options(*this, homed, context));
}

client::Outcome HomeCommand::run(CommandContext& context) const {
  auto found = context.axes.axis_to_command(axis, take_over);
  if (!found) return found.outcome();
  context.progress.axis(*found, context.axes.label_of(found->id()), "homing");
  return report_axis(context, *found,
                     {.command = "home",
                      .outcome = found->home(homing_options(*this, *found, context)),
                      .has_arrived = until == client::Until::done});
}

extern const CommandRow kHome =
    row_of<HomeCommand>({.name = "home",
                         .group = CommandGroup::motion,
                         .summary = "Home the axis (mode 6) and wait until home is attained",
                         .example = "home 1.1 --method 37 --offset 0deg"});

}  // namespace vdrive::tool
