// SPDX-License-Identifier: Apache-2.0
// The commands for the time of a bench: step, rate and snapshot.
#include "commands/clock.hpp"

#include "base/usage_error.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "vdrive/client/step_clock.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <array>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::tool {

void StepCommand::declare(Arguments& arguments) {
  constexpr std::uint64_t kMostTicks = 1'000'000'000;
  arguments.positional("N", ticks, "Ticks", [](const std::string& text) {
    return parse_number(text, "number of ticks", kMostTicks);
  });
  arguments.bench(bench);
  arguments.option("--steppers", "N", steppers,
                   "Join the clock for this step: time stands still until N programs, including "
                   "this one, have joined; default: step alone",
                   [](const std::string& text) {
                     return static_cast<std::uint32_t>(parse_number(
                         text, "number of steppers", client::StepClock::kMostSteppers));
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
  return report_tick({{"bench", found->number, name}, {"ticks", ticks}}, reached, context.output);
}

extern const CommandRow kStep = row_of<StepCommand>({.name = "step",
                                                     .group = CommandGroup::bench,
                                                     .summary = "Step a lock-step bench by N ticks",
                                                     .example = "step 1000 --bench 2"});

namespace {

using client::Outcome;

Record rate_record(const client::BenchInfo& bench) {
  const std::string clock(to_string(bench.clock_mode));
  Record record{{"bench", bench.number, "bench " + std::to_string(bench.number)},
                {"clock", clock, clock},
                {"rate", nullptr}};
  if (bench.clock_mode == client::ClockMode::realtime) {
    record.back() = {"rate", bench.rate, "rate " + to_text(bench.rate)};
  }
  return record;
}

Outcome show_rates(const CommandContext& context) {
  const auto benches = context.session.find_benches();
  if (benches.empty()) return context.session.no_bench_found();
  for (const client::BenchInfo& bench : benches) print(rate_record(bench), context.output);
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
  const auto set = context.session.set_rate(found->number, *rate);
  if (set) context.changes.note_rate(found->number, found->rate);
  return report_tick({{"bench", found->number, "bench " + std::to_string(found->number)},
                      {"rate", *rate, "rate " + Json(*rate).dump()}},
                     set, context.output);
}

extern const CommandRow kRate =
    row_of<RateCommand>({.name = "rate",
                         .group = CommandGroup::bench,
                         .summary = "Set or show how fast a realtime bench runs; 0 pauses it",
                         .example = "rate 0.5\n  vdrive rate 2 0       # bench 2"});

namespace {

using Action = SnapshotCommand::Action;

Action parse_action(const std::string& text) {
  for (const Action known : {Action::take, Action::list, Action::restore, Action::drop}) {
    if (text == to_string(known)) return known;
  }
  throw UsageError(in_quotes(text) + " is not an action: write take, list, restore or drop" +
                   suggestion(text, {"take", "list", "restore", "drop"}));
}

/// @param number of the snapshot, as text; empty if not given
std::uint64_t parse_snapshot(Action action, const std::string& number) {
  const bool takes_number = action == Action::restore || action == Action::drop;
  if (number.empty() == takes_number) {
    throw UsageError("'snapshot " + std::string(to_string(action)) + "' takes " +
                     (number.empty() ? "the number of a snapshot" : "no number"));
  }
  constexpr auto kHighest = std::numeric_limits<std::int64_t>::max();
  return number.empty() ? 0 : parse_number(number, "snapshot number", kHighest);
}

void print_snapshots(const client::BenchInfo& bench, std::span<const client::KeptSnapshot> kept,
                     const Output& output) {
  const std::string name = "bench " + std::to_string(bench.number);
  if (kept.empty() && !output.is_json) output.terminal.print(name + " keeps no snapshot");
  for (const client::KeptSnapshot& snapshot : kept) {
    print({{"bench", bench.number, name},
           {"action", "list"},
           {"snapshot", snapshot.number, "snapshot " + std::to_string(snapshot.number) + ","},
           {"tick", snapshot.tick,
            "taken at tick " + std::to_string(snapshot.tick) + ", " +
                counted(bench.axes.size(), "axis", "axes")}},
          output);
  }
}

/// Lists the snapshots of one bench, or of all benches if none is named.
Outcome list_snapshots(std::optional<std::uint32_t> number, const CommandContext& context) {
  const auto benches = benches_to_show(context.session, number);
  if (!benches) return benches.outcome();
  for (const client::BenchInfo& bench : *benches) {
    const auto kept = context.session.snapshots(bench.number);
    if (!kept) return kept.outcome();
    print_snapshots(bench, *kept, context.output);
  }
  return {};
}

/// @param number of the snapshot; receives the new number after take
Outcome change_snapshots(Action action, std::uint32_t bench, std::uint64_t& number,
                         client::Session& session) {
  if (action == Action::restore) return session.restore_snapshot(bench, number).outcome();
  if (action == Action::drop) return session.drop_snapshot(bench, number);
  const auto taken = session.take_snapshot(bench);
  number = taken ? *taken : 0;
  return taken.outcome();
}

}  // namespace

void SnapshotCommand::declare(Arguments& arguments) {
  std::string& word = arguments.text();
  std::string& number = arguments.text();
  arguments.positional("ACTION", word, "take, list, restore or drop")
      .required()
      .completed_by(complete_one_of({"take", "restore", "drop", "list"}));
  arguments.positional("N", number, "Number of the snapshot, as take and list print it");
  arguments.bench(bench);
  arguments.then([this, &word, &number] {
    action = parse_action(word);
    snapshot = parse_snapshot(action, number);
  });
}

Outcome SnapshotCommand::run(CommandContext& context) const {
  if (action == Action::list) return list_snapshots(bench, context);
  const auto found =
      find_bench(context.session, bench, "write for example: snapshot take --bench 2");
  if (!found) return found.outcome();
  std::uint64_t number = snapshot;
  Outcome outcome = change_snapshots(action, found->number, number, context.session);
  if (outcome) {
    print_answer({{"bench", found->number, "bench " + std::to_string(found->number)},
                  {"action", to_string(action)},
                  {"snapshot", number, "snapshot " + std::to_string(number)}},
                 outcome, context.output);
  }
  return outcome;
}

std::string_view to_string(SnapshotCommand::Action action) noexcept {
  switch (action) {
    case Action::take:
      return "take";
    case Action::restore:
      return "restore";
    case Action::drop:
      return "drop";
    case Action::list:
      return "list";
  }
  return "unknown";
}

extern const CommandRow kSnapshot = row_of<SnapshotCommand>(
    {.name = "snapshot",
     .group = CommandGroup::bench,
     .summary = "Take, list, restore or drop saved states of all axes of a bench",
     .example = "snapshot take\n  vdrive snapshot restore 1"});

}  // namespace vdrive::tool
