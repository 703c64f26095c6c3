// SPDX-License-Identifier: Apache-2.0
#include "commands/step.hpp"

#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "vdrive/client/step_clock.hpp"
#include "vdrive/wording.hpp"

#include <array>
#include <string>

namespace vdrive::tool {

void StepCommand::declare(Arguments& arguments) {
  constexpr std::uint64_t kMostTicks = 1'000'000'000;
  arguments.positional("N", ticks, "Ticks", [](const std::string& text) {
    return parse_number(text, "number of ticks", kMostTicks);
  });
  arguments.bench(bench);
  arguments.option(
      "--steppers", "N", steppers,
      "Join the clock for this step: time stands until N programs, including this one, "
      "have joined; default: step alone",
      [](const std::string& text) {
        return static_cast<std::uint32_t>(
            parse_number(text, "number of steppers", client::StepClock::kMostSteppers));
      });
}

/// @return the tick reached.
client::Result<std::uint64_t> StepCommand::step(client::Session& session,
                                                std::uint32_t number) const {
  if (steppers == 0) return session.step(number, ticks);
  auto clock = client::StepClock::join(session, std::array{number}, steppers);
  if (!clock) return clock.outcome();
  const auto reached = clock->step(ticks);
  if (!reached) return reached.outcome();
  return reached->front();
}

client::Outcome StepCommand::run(CommandContext& context) const {
  const auto found = find_bench(context.session, bench, "write for example: step 1000 --bench 2");
  if (!found) return found.outcome();
  const std::string name = "bench " + std::to_string(found->number);
  context.progress.time(name + ": " + counted(ticks, "tick", "ticks"));
  const auto reached = step(context.session, found->number);
  context.progress.end();
  return report_clock(context.output, {{"bench", found->number}, {"ticks", ticks}}, name, reached);
}

extern const CommandRow kStep = row_of<StepCommand>({.name = "step",
                                                     .group = CommandGroup::bench,
                                                     .summary = "Step a lock-step bench by N ticks",
                                                     .example = "step 1000 --bench 2"});

}  // namespace vdrive::tool
