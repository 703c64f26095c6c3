// SPDX-License-Identifier: Apache-2.0
#include "commands/rate.hpp"

#include "base/usage_error.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "vdrive/number_text.hpp"

#include <string>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;

std::string rate_line(const client::BenchInfo& bench) {
  const bool has_rate = bench.clock_mode == client::ClockMode::realtime;
  return "bench " + std::to_string(bench.number) + " " + std::string(to_string(bench.clock_mode)) +
         (has_rate ? " rate " + to_text(bench.rate) : std::string());
}

Json rate_json(const client::BenchInfo& bench) {
  const bool has_rate = bench.clock_mode == client::ClockMode::realtime;
  return {{"bench", bench.number},
          {"clock", to_string(bench.clock_mode)},
          {"rate", has_rate ? Json(bench.rate) : Json(nullptr)}};
}

Outcome show_rates(const CommandContext& context) {
  const auto benches = context.session.find_benches();
  if (benches.empty()) return context.session.no_bench_found();
  for (const client::BenchInfo& bench : benches) {
    context.output.terminal.print(context.output.is_json ? to_line(rate_json(bench))
                                                         : rate_line(bench));
  }
  return {};
}

}  // namespace

void RateCommand::declare(Arguments& arguments) {
  arguments.positionals(
      "VALUE", *this,
      "[BENCH] VALUE: drive time divided by wall time, 0 or from 0.1 to 100; BENCH defaults to the "
      "only bench. Without a value the rates of all benches are shown",
      [](const std::vector<std::string>& values) {
        if (values.size() > 2) throw UsageError("rate takes at most a bench and a value");
        RateCommand read;
        if (!values.empty()) read.rate = parse_real(values.back(), "rate");
        if (values.size() == 2) read.bench = parse_bench(values.front());
        return read;
      });
}

Outcome RateCommand::run(CommandContext& context) const {
  if (!rate) return show_rates(context);
  const auto found = find_bench(context.session, bench, "write for example: rate 2 0.5");
  if (!found) return found.outcome();
  const Json json{{"bench", found->number}, {"rate", *rate}};
  const auto set = context.session.set_rate(found->number, *rate);
  if (set) context.changes.note_rate(found->number, found->rate);
  return report_clock(context.output, json,
                      "bench " + std::to_string(found->number) + " rate " + json["rate"].dump(),
                      set);
}

extern const CommandRow kRate =
    row_of<RateCommand>({.name = "rate",
                         .group = CommandGroup::bench,
                         .summary = "Set or show how fast a realtime bench runs; 0 pauses it",
                         .example = "rate 0.5\n  vdrive rate 2 0       # bench 2"});

}  // namespace vdrive::tool
