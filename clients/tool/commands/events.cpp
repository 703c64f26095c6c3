// SPDX-License-Identifier: Apache-2.0
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "output/event_view.hpp"

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;

std::vector<std::string> complete_source(std::span<const std::string> before,
                                         const BenchNames& names) {
  if (!before.empty()) return {};
  std::vector<std::string> words = names.axes();
  std::ranges::move(names.benches(), std::back_inserter(words));
  return words;
}

bool is_number(const std::string& text) {
  return std::ranges::all_of(text, [](char c) {
    return c >= '0' && c <= '9';
  });
}

struct EventsCommand {
  std::string source{};  ///< number of a bench, or an axis; empty = all benches
  bool follow = false;

  void declare(Arguments& arguments) {
    arguments.positional("WHAT", source, "A bench's number or an axis; default: all benches")
        .completed_by(complete_source);
    arguments.flag("--follow", follow, "Then print new events until interrupted");
  }

  Outcome run(CommandContext& context) const {
    EventChoice choice{
        .bench = {}, .axis = {}, .follow = follow, .is_json = context.output.is_json};
    if (source.empty()) {
      if (context.session.find_benches().empty()) return context.session.no_bench_found();
    } else if (is_number(source)) {
      choice.bench = parse_bench(source);
      const auto bench = context.session.find_bench(choice.bench);
      if (!bench) return bench.outcome();
    } else {
      const auto axis = context.axes.axis(source);
      if (!axis) return axis.outcome();
      choice.axis = axis->id();
    }
    return show_events(context.session, choice, context.output.terminal);
  }
};

}  // namespace

extern const CommandRow kEvents = row_of<EventsCommand>(
    {.name = "events",
     .group = CommandGroup::observation,
     .summary = "Show events: state changes, faults, refusals, changes of control",
     .example = "events 1.1 --follow",
     .deepest = Place::shell});

}  // namespace vdrive::tool
