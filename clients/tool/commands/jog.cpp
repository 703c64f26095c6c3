// SPDX-License-Identifier: Apache-2.0
#include "commands/jog.hpp"

#include "execution/axis_report.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>

namespace vdrive::tool {
namespace {

using client::Outcome;

/// @return whether Enter was pressed, or standard input has ended.
bool is_enter_pressed() {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  if (poll(&input, 1, 0) <= 0) return false;
  std::array<char, 64> text{};
  // At the end of the input, too, the jog is no longer held.
  return read(STDIN_FILENO, text.data(), text.size()) >= 0;
}

/// How long a jog is held: a drive time, or until Enter is pressed.
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
  // A shell and a scenario read the lines of standard input: Enter is one of them.
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
    context.output.terminal.complain("vdrive: Enter or Ctrl-C stops the axis");
  }
  JogHold hold(ticks);
  const Outcome jogged = found->jog(
      velocity,
      [&hold](const client::AxisSnapshot& seen) {
        return hold.is_held(seen);
      },
      run_at.options(context, *found, client::Until::done));
  if (jogged && context.session.is_interrupted()) {
    context.output.terminal.complain("vdrive: interrupted; axis " +
                                     context.axes.label_of(found->id()) + " stands");
  }
  return report_axis(context, *found, {.command = "jog", .outcome = jogged, .has_arrived = true});
}

extern const CommandRow kJog =
    row_of<JogCommand>({.name = "jog",
                        .group = CommandGroup::motion,
                        .summary = "Run at a velocity until Enter or Ctrl-C, then stop",
                        .example = "jog 1.1 90deg/s --for 2s"});

}  // namespace vdrive::tool
