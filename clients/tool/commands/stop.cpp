// SPDX-License-Identifier: Apache-2.0
#include "commands/stop.hpp"

#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "vdrive/wording.hpp"

namespace vdrive::tool {

void StopCommand::declare(Arguments& arguments) {
  arguments.optional_positional("BENCH", bench, "Default: the only bench", parse_bench)
      .completed_by(complete_bench);
  arguments.no_wait(until);
}

client::Outcome StopCommand::run(CommandContext& context) const {
  const auto found = context.session.find_bench(bench);
  if (!found) return found.outcome();
  client::Outcome outcome = context.session.quick_stop(found->number, context.call_options(until));
  const Output& output = context.output;
  if (output.is_quiet) return outcome;
  if (output.is_json) {
    Json json{{"bench", found->number}, {"command", "stop"}, {"axes", found->axes.size()}};
    add_outcome(json, outcome);
    output.terminal.print(to_line(json));
  } else if (outcome) {
    output.terminal.print("bench " + std::to_string(found->number) + ": quick stop of " +
                          counted(found->axes.size(), "axis", "axes"));
  }
  return outcome;
}

extern const CommandRow kStop =
    row_of<StopCommand>({.name = "stop",
                         .group = CommandGroup::power,
                         .summary = "Quick stop of every axis of a bench, also of other sessions",
                         .example = "stop 1"});

}  // namespace vdrive::tool
