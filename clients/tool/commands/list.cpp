// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_states.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <string>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;

/// @return ", paused" or ", rate 0.5" for a realtime bench that does not run at the rate of the
///         wall clock.
std::string rate_text(const client::BenchInfo& bench) {
  if (bench.clock_mode != client::ClockMode::realtime || bench.rate == 1.0) return {};
  return bench.rate == 0.0 ? ", paused" : ", rate " + to_text(bench.rate);
}

std::string heading_of(const client::BenchInfo& bench, std::uint64_t tick,
                       const Terminal& terminal) {
  return colored(terminal, Color::bold,
                 "bench " + std::to_string(bench.number) + " " + escaped(bench.name)) +
         ", " + std::string(to_string(bench.clock_mode)) + ", tick " + std::to_string(tick) +
         " of " + std::to_string(bench.period.count()) + " us" + rate_text(bench) +
         (bench.host.empty() ? "" : ", on " + escaped(bench.host)) + ", version " +
         escaped(bench.service_version);
}

Outcome list_bench(const client::BenchInfo& bench, const CommandContext& context) {
  std::vector<client::AxisId> ids;
  for (const client::AxisInfo& axis : bench.axes) ids.push_back(axis.id);
  const auto seen = context.session.observe(ids);
  if (!seen) return seen.outcome();
  Terminal& terminal = context.output.terminal;
  if (!context.output.is_json) terminal.print(heading_of(bench, seen->tick, terminal));
  for (std::size_t i = 0; i < bench.axes.size(); ++i) {
    const client::AxisSnapshot& axis = seen->axes[i];
    print(list_record(bench, bench.axes[i], axis, owner_of(context.session, axis)), context.output);
  }
  return {};
}

struct ListCommand {
  void declare(Arguments& /*arguments*/) {}

  static Outcome run(CommandContext& context) {
    const auto benches = context.session.find_benches();
    if (benches.empty()) return context.session.no_bench_found();
    for (const client::BenchInfo& bench : benches) {
      if (Outcome listed = list_bench(bench, context); !listed) return listed;
    }
    return {};
  }
};

}  // namespace

extern const CommandRow kList = row_of<ListCommand>({.name = "list",
                                                     .group = CommandGroup::observation,
                                                     .summary = "List all benches and axes",
                                                     .example = "list --json"});

}  // namespace vdrive::tool
