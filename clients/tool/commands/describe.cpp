// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_report.hpp"
#include "execution/axis_states.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "output/axis_description.hpp"
#include "output/event_view.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;

/// One axis with the values read from it, or why reading failed.
struct DescribedAxis {
  client::Axis axis;
  const client::AxisSnapshot& status;
  client::Result<client::Readings> readings;
};

/// @return each bench of the axes once.
client::Result<std::map<std::uint32_t, client::BenchInfo>> benches_of(
    client::Session& session, const std::vector<client::Axis>& axes) {
  std::map<std::uint32_t, client::BenchInfo> benches;
  for (const client::Axis& axis : axes) {
    const std::uint32_t number = axis.id().bench;
    if (benches.contains(number)) continue;
    auto bench = session.find_bench(number);
    if (!bench) return bench.outcome();
    benches.emplace(number, *std::move(bench));
  }
  return benches;
}

/// @param shown status of the axes; axes without a status, because their bench did not answer, are
///        left out of the result
std::vector<DescribedAxis> read_objects(const std::vector<client::Axis>& axes,
                                        const AxisStates& shown) {
  std::vector<DescribedAxis> read;
  read.reserve(axes.size());
  for (const client::Axis& axis : axes) {
    const auto status = shown.states.find(axis.id());
    if (status == shown.states.end()) continue;
    read.push_back({axis, status->second, axis.read(described_objects())});
  }
  return read;
}

/// Reads events only if there is a fault: waiting for them takes longer than everything else.
std::vector<client::Event> events_needed(client::Session& session,
                                         const std::vector<DescribedAxis>& axes) {
  const bool has_fault = std::ranges::any_of(axes, [](const DescribedAxis& axis) {
    return axis.readings && last_fault_of(axis.status, *axis.readings);
  });
  return has_fault ? kept_events(session) : std::vector<client::Event>{};
}

AxisDescription description_of(const DescribedAxis& axis, const client::BenchInfo& bench,
                               const std::vector<client::Event>& events) {
  const auto info = std::ranges::find(bench.axes, axis.axis.id(), &client::AxisInfo::id);
  ensure(info != bench.axes.end(), "an axis that was found is one of its bench");
  AxisDescription described{
      .bench = bench, .axis = *info, .status = axis.status, .readings = *axis.readings};
  if (const auto code = last_fault_of(described.status, described.readings)) {
    described.fault_tick = tick_of_fault(events, axis.axis.id(), *code);
  }
  return described;
}

void show_description(const AxisDescription& described, const Output& output) {
  if (output.is_json) {
    output.terminal.print(to_line(description_json(described)));
    return;
  }
  for (const std::string& line : description_text(described)) output.terminal.print(line);
}

/// With --json, a failure is a separate object.
void show_failure(const DescribedAxis& axis, const CommandContext& context) {
  Record record{{"axis", to_string(axis.axis.id())}};
  add_outcome(record, context.axes.named(axis.readings.outcome()));
  print(record, context.output);
}

/// Prints everything known about axes.
struct DescribeCommand {
  std::vector<std::string> axes{};

  void declare(Arguments& arguments) { arguments.axes_or_all(axes); }

  Outcome run(CommandContext& context) const {
    const auto found = context.axes.axes(axes);
    if (!found) return found.outcome();
    const auto benches = benches_of(context.session, *found);
    if (!benches) return benches.outcome();
    const AxisStates shown = states_of(context.session, *found);
    AxisFailures failures;
    failures.take(shown.outcome, context);
    const std::vector<DescribedAxis> described = read_objects(*found, shown);
    const auto events = events_needed(context.session, described);
    for (const DescribedAxis& axis : described) {
      if (axis.readings) {
        show_description(description_of(axis, benches->at(axis.axis.id().bench), events),
                         context.output);
      } else {
        show_failure(axis, context);
        failures.take(axis.readings.outcome(), context);
      }
    }
    return std::move(failures).first();
  }
};

}  // namespace

extern const CommandRow kDescribe = row_of<DescribeCommand>(
    {.name = "describe",
     .group = CommandGroup::observation,
     .summary = "Show everything about axes: state, last fault, model, changed objects",
     .example = "describe 1.1\n  vdrive describe 7.1 lift --json"});

}  // namespace vdrive::tool
