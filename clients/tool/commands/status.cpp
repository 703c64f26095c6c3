// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_states.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "language/command.hpp"
#include "terminal/columns.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <string>
#include <utility>
#include <vector>

namespace vdrive::tool {
namespace {

using client::Outcome;

/// @return the axis as one line of several.
std::string short_line(const client::Axis& axis, const client::AxisSnapshot& status) {
  return status_line(status,
                     padded(to_string(axis.id()), 6) + " " + padded(escaped(axis.name()), 16),
                     axis.unit());
}

/// @param is_only_one full output, otherwise one line
void show_status(const client::Axis& axis, const client::AxisSnapshot& status, bool is_only_one,
                 const CommandContext& context) {
  const Output& output = context.output;
  AxisLabel label{axis.name(), axis.unit()};
  if (output.is_json || is_only_one) label.owner = owner_of(context.session, status);
  if (output.is_json) {
    Json json = status_json(status, label);
    json["owner_name"] = name_json(label.owner);
    output.terminal.print(to_line(json));
  } else if (is_only_one) {
    for (const std::string& line : status_text(status, label)) output.terminal.print(line);
  } else {
    const std::string line = short_line(axis, status);
    const auto color = color_of(status);
    output.terminal.print(color ? colored(output.terminal, *color, line) : line);
  }
}

struct StatusCommand {
  std::vector<std::string> axes{};  ///< none = all axes of all benches

  void declare(Arguments& arguments) { arguments.axes(axes, "default: every axis of every bench"); }

  Outcome run(CommandContext& context) const {
    const auto found = axes.empty() ? context.axes.axes_of_all_benches() : context.axes.axes(axes);
    if (!found) return found.outcome();
    context.progress.time("status of " + counted(found->size(), "axis", "axes"));
    AxisStates shown = states_of(context.session, *found);
    context.progress.end();
    for (const client::Axis& axis : *found) {
      const auto state = shown.states.find(axis.id());
      if (state == shown.states.end()) continue;
      show_status(axis, state->second, found->size() == 1, context);
    }
    return std::move(shown.outcome);
  }
};

}  // namespace

extern const CommandRow kStatus = row_of<StatusCommand>(
    {.name = "status",
     .group = CommandGroup::observation,
     .summary = "Show one axis with its statusword decoded, or several axes, one per line",
     .example = "status 1.1\n  vdrive status         # every axis"});

}  // namespace vdrive::tool
