// SPDX-License-Identifier: Apache-2.0
#include "commands/move.hpp"

#include "execution/axis_report.hpp"
#include "execution/command_context.hpp"
#include "execution/motion_end.hpp"
#include "language/arguments.hpp"
#include "output/live_view.hpp"

#include <cstdint>
#include <optional>

namespace vdrive::tool {
namespace {

using client::Outcome;

client::MoveOptions move_options(const MoveCommand& command, const client::Axis& axis,
                                 const CommandContext& context) {
  return {.velocity = context.axes.limit(axis, command.velocity),
          .acceleration = context.axes.limit(axis, command.acceleration),
          .deceleration = context.axes.limit(axis, command.deceleration),
          .queue = command.queue,
          .call = context.call_options(command.until)};
}

/// Reports whether the axis still moves after an interrupted move.
void report_interrupt(client::Axis& axis, bool stops, const Outcome& moved,
                      const CommandContext& context) {
  if (stops) {
    halt_after_interrupt(axis, context);
  } else if (!moved) {
    context.output.terminal.print_error("vdrive: " + moved.message());
  }
}

}  // namespace

void MoveCommand::declare(Arguments& arguments) {
  arguments.axis(axis);
  arguments.positional("POSITION", position,
                       "Target, or distance with --relative [UU, or with a unit: 90deg, 12.5mm]",
                       parse_position);
  arguments.flag("--relative", relative, "POSITION is a distance (bit 6)");
  arguments.option("--velocity", "V", velocity, "6081h [UU/s, or 180deg/s] for this move",
                   parse_speed);
  arguments.option("--acceleration", "A", acceleration, "6083h [UU/s2, or 900deg/s2] for this move",
                   parse_ramp);
  arguments.option("--deceleration", "D", deceleration, "6084h [UU/s2, or 900deg/s2] for this move",
                   parse_ramp);
  arguments.flag("--queue", queue,
                 "Queue after the present move instead of replacing it (bit 5 = 0)");
  arguments.no_wait(until, "Return when the drive has accepted the set-point");
  arguments.flag("--stop-on-interrupt", stop_on_interrupt,
                 "Halt the axis when Ctrl-C ends the wait; it continues otherwise");
  arguments.take_over(take_over);
}

void MoveCommand::check_units(const CommandContext& context, const client::Axis& moved) const {
  static_cast<void>(context.axes.user_units(moved, position));
  static_cast<void>(move_options(*this, moved, context));
}

Outcome MoveCommand::run(CommandContext& context) const {
  auto found = context.axes.axis_to_command(axis, take_over);
  if (!found) return found.outcome();
  const auto target = static_cast<std::int32_t>(context.axes.user_units(*found, position));
  const client::MoveOptions options = move_options(*this, *found, context);
  if (context.live_view != nullptr && !relative) context.live_view->aim(found->id(), target);
  context.progress.motion(*found, context.axes.label_of(found->id()),
                          relative ? std::nullopt : std::optional(target));
  const Outcome moved =
      relative ? found->move_by(target, options) : found->move_to(target, options);
  context.progress.end();
  if (moved) context.judge.note_control(found->id());
  Terminal& terminal = context.output.terminal;
  const bool leaves_ramps =
      until == client::Until::in_force && (options.acceleration || options.deceleration);
  if (moved && leaves_ramps && !context.output.is_quiet) {
    terminal.print_error(
        "vdrive: the ramps of this move act while it lasts: 6083h and 6084h stay as given");
  }
  if (context.session.is_interrupted()) {
    report_interrupt(*found, stop_on_interrupt, moved, context);
  }
  return report_axis(
      context, *found,
      {.command = "move", .outcome = moved, .has_arrived = until == client::Until::done});
}

extern const CommandRow kMove =
    row_of<MoveCommand>({.name = "move",
                         .group = CommandGroup::motion,
                         .summary = "Move to a position and wait until it is reached",
                         .example = "move 1.1 10000 --velocity 1000 --acceleration 6000"});

}  // namespace vdrive::tool
