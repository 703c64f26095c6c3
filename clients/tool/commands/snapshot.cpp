// SPDX-License-Identifier: Apache-2.0
#include "commands/snapshot.hpp"

#include "base/usage_error.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;
using Action = SnapshotCommand::Action;

Action parse_action(const std::string& text) {
  for (const Action known : {Action::take, Action::list, Action::restore, Action::drop}) {
    if (text == to_string(known)) return known;
  }
  throw UsageError(in_quotes(text) + " is not an action: write take, list, restore or drop" +
                   suggestion(text, {"take", "list", "restore", "drop"}));
}

/// @param number of the snapshot, as text; empty where it was not given
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
    output.terminal.print(output.is_json ? to_line({{"bench", bench.number},
                                                    {"action", "list"},
                                                    {"snapshot", snapshot.number},
                                                    {"tick", snapshot.tick}})
                                         : name + " snapshot " + std::to_string(snapshot.number) +
                                               ", taken at tick " + std::to_string(snapshot.tick) +
                                               ", " + counted(bench.axes.size(), "axis", "axes"));
  }
}

/// Of one bench, or of all where none is named.
Outcome list_snapshots(std::optional<std::uint32_t> number, const CommandContext& context) {
  std::vector<client::BenchInfo> benches;
  if (number) {
    auto bench = context.session.find_bench(number);
    if (!bench) return bench.outcome();
    benches.push_back(std::move(*bench));
  } else {
    benches = context.session.find_benches();
    if (benches.empty()) return context.session.no_bench_found();
  }
  for (const client::BenchInfo& bench : benches) {
    const auto kept = context.session.snapshots(bench.number);
    if (!kept) return kept.outcome();
    print_snapshots(bench, *kept, context.output);
  }
  return {};
}

/// @param number of the snapshot; that of the new one after take
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
  const Output& output = context.output;
  if (!outcome || output.is_quiet) return outcome;
  if (output.is_json) {
    output.terminal.print(
        to_line({{"bench", found->number}, {"action", to_string(action)}, {"snapshot", number}}));
  } else {
    output.terminal.print("bench " + std::to_string(found->number) + " snapshot " +
                          std::to_string(number));
  }
  return {};
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
