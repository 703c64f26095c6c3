// SPDX-License-Identifier: Apache-2.0
#include "commands/motion.hpp"

#include "execution/axis_report.hpp"
#include "execution/command_context.hpp"
#include "execution/motion_end.hpp"
#include "language/arguments.hpp"
#include "values/units.hpp"
#include "vdrive/cia402/homing_method.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <utility>
#include <vector>

namespace vdrive::tool {

void VelocityArguments::declare(Arguments& arguments, std::string& axis) {
  arguments.axis(axis);
  arguments.positional("VELOCITY", velocity, "60FFh [UU/s, or 180deg/s]", parse_velocity);
  arguments.option("--acceleration", "A", acceleration,
                   "6083h [UU/s2, or 900deg/s2]; keeps this value", parse_ramp);
  arguments.option("--deceleration", "D", deceleration,
                   "6084h [UU/s2, or 900deg/s2]; keeps this value", parse_ramp);
  arguments.take_over(take_over);
}

void VelocityArguments::check_units(const AxisFinder& axes, const client::Axis& axis) const {
  static_cast<void>(axes.user_units(axis, velocity));
  static_cast<void>(axes.limit(axis, acceleration));
  static_cast<void>(axes.limit(axis, deceleration));
}

std::int32_t VelocityArguments::velocity_of(const AxisFinder& axes,
                                            const client::Axis& axis) const {
  return static_cast<std::int32_t>(axes.user_units(axis, velocity));
}

client::VelocityOptions VelocityArguments::options(const CommandContext& context,
                                                   const client::Axis& axis,
                                                   client::Until until) const {
  client::VelocityOptions options;
  options.acceleration = context.axes.limit(axis, acceleration);
  options.deceleration = context.axes.limit(axis, deceleration);
  options.call = context.call_options(until);
  return options;
}

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

namespace {

using client::Outcome;

/// @return whether Enter was pressed, or standard input has ended.
bool is_enter_pressed() {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  if (poll(&input, 1, 0) <= 0) return false;
  std::array<char, 64> text{};
  // The end of the input also ends the jog.
  return read(STDIN_FILENO, text.data(), text.size()) >= 0;
}

/// How long a jog is held: for a drive time, or until Enter is pressed.
class JogHold {
 public:
  explicit JogHold(std::optional<std::uint64_t> ticks) : ticks_(ticks) {}

  [[nodiscard]] bool is_held(const client::AxisSnapshot& axis) {
    if (!first_) first_ = axis.driven_tick();
    return ticks_ ? axis.driven_tick() < *first_ + *ticks_ : !is_enter_pressed();
  }

 private:
  std::optional<std::uint64_t> ticks_;
  std::optional<std::uint64_t> first_;
};

}  // namespace

void JogCommand::declare(Arguments& arguments) {
  run_at.declare(arguments, axis);
  Argument time =
      arguments.option("--for", "T", duration, "Run for this drive time instead", parse_duration);
  // A shell and a scenario read their lines from standard input, so Enter would be one of them.
  if (arguments.place() != Place::command_line) time.required();
}

void JogCommand::check_units(const CommandContext& context, const client::Axis& driven) const {
  run_at.check_units(context.axes, driven);
}

Outcome JogCommand::run(CommandContext& context) const {
  auto found = context.axes.axis_to_command(axis, run_at.take_over);
  if (!found) return found.outcome();
  const auto velocity = run_at.velocity_of(context.axes, *found);
  std::optional<std::uint64_t> ticks;
  if (duration) {
    const auto bench = context.session.find_bench(found->id().bench);
    if (!bench) return bench.outcome();
    ticks = client::ticks_of(*duration, bench->period);
  } else if (!context.output.is_quiet) {
    context.output.terminal.print_error("vdrive: Enter or Ctrl-C stops the axis");
  }
  JogHold hold(ticks);
  const Outcome jogged = found->jog(
      velocity,
      [&hold](const client::AxisSnapshot& seen) {
        return hold.is_held(seen);
      },
      run_at.options(context, *found, client::Until::done));
  if (jogged && context.session.is_interrupted()) {
    context.output.terminal.print_error("vdrive: interrupted; axis " +
                                        context.axes.label_of(found->id()) + " is at standstill");
  }
  return report_axis(context, *found, {.command = "jog", .outcome = jogged, .has_arrived = true});
}

extern const CommandRow kJog =
    row_of<JogCommand>({.name = "jog",
                        .group = CommandGroup::motion,
                        .summary = "Run at a velocity until Enter or Ctrl-C, then stop",
                        .example = "jog 1.1 90deg/s --for 2s"});

}  // namespace vdrive::tool
