// SPDX-License-Identifier: Apache-2.0
#include "commands/step.hpp"

#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "vdrive/wording.hpp"

#include <string>

namespace vdrive::tool {

void StepCommand::declare(Arguments& arguments) {
  constexpr std::uint64_t kMostTicks = 1'000'000'000;
  arguments.positional("N", ticks, "Ticks", [](const std::string& text) {
    return parse_number(text, "number of ticks", kMostTicks);
  });
  arguments.bench(bench);
}

client::Outcome StepCommand::run(CommandContext& context) const {
  const auto found = find_bench(context.session, bench, "write for example: step 1000 --bench 2");
  if (!found) return found.outcome();
  const std::string name = "bench " + std::to_string(found->number);
  context.progress.time(name + ": " + counted(ticks, "tick", "ticks"));
  const auto reached = context.session.step(found->number, ticks);
  context.progress.end();
  return report_clock(context.output, {{"bench", found->number}, {"ticks", ticks}}, name, reached);
}

extern const CommandRow kStep = row_of<StepCommand>({.name = "step",
                                                     .group = CommandGroup::bench,
                                                     .summary = "Step a lock-step bench by N ticks",
                                                     .example = "step 1000 --bench 2"});

}  // namespace vdrive::tool
