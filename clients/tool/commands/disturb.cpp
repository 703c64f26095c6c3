// SPDX-License-Identifier: Apache-2.0
#include "commands/disturb.hpp"

#include "base/usage_error.hpp"
#include "execution/command_context.hpp"
#include "execution/object_write.hpp"
#include "language/arguments.hpp"
#include "values/object_check.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <string_view>

namespace vdrive::tool {
namespace {

using client::Outcome;

std::vector<std::string> names_of_disturbances() {
  std::vector<std::string> names{"none"};
  for (const client::DisturbanceRow& row : client::kDisturbances) names.emplace_back(row.name);
  return names;
}

std::string help_of_kinds() {
  std::string help;
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    const std::string_view units = describe(*find_object(row.variable_name)).units;
    help.append(row.name);
    if (units != "-") help.append(" [").append(units).append("]");
    help.append("\n    ").append(text_of(row)).append("\n");
  }
  return help + "none\n    clears all of them";
}

std::vector<Disturbance> inputs_of(const std::string& kind, const std::string& value) {
  std::vector<Disturbance> inputs;
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    if (kind != row.name && kind != "none") continue;
    const ObjectName object = parse_object(row.variable_name);
    inputs.push_back({object, kind == "none" ? 0 : parse_value(value, object)});
  }
  if (!inputs.empty()) return inputs;
  std::string message = in_quotes(kind) + " is not a disturbance: write";
  for (const client::DisturbanceRow& row : client::kDisturbances) {
    message += " " + std::string(row.name) + ",";
  }
  throw UsageError(message + " or none" + suggestion(kind, names_of_disturbances()));
}

/// Several inputs at once are all of them, cleared: one line, or one object.
Outcome clear_all(CommandContext& context, client::Axis& axis,
                  const std::vector<Disturbance>& inputs) {
  client::Result<std::uint64_t> tick = std::uint64_t{0};
  for (const Disturbance& input : inputs) {
    tick = write_unprinted(context, axis, input.object, 0);
    if (!tick) break;
  }
  const Output& output = context.output;
  if (output.is_quiet) return tick.outcome();
  if (output.is_json) {
    Json json{{"axis", to_string(axis.id())}, {"command", "disturb"}, {"inputs", inputs.size()}};
    add_outcome(json, context.axes.named(tick.outcome()));
    if (tick) json["tick"] = *tick;
    output.terminal.print(to_line(json));
  } else if (tick) {
    output.terminal.print(context.axes.label_of(axis.id()) +
                          " every test input is 0, in force at tick " + std::to_string(*tick));
  }
  return tick.outcome();
}

Outcome set_inputs(CommandContext& context, client::Axis& axis,
                   const std::vector<Disturbance>& inputs) {
  if (inputs.size() > 1) return clear_all(context, axis, inputs);
  return write_object(context, axis, inputs.front().object, inputs.front().value);
}

}  // namespace

void DisturbCommand::declare(Arguments& arguments) {
  arguments.axis(axis);
  std::string& kind = arguments.text();
  std::string& value = arguments.text();
  arguments.positional("KIND", kind, help_of_kinds())
      .required()
      .completed_by([](auto, const BenchNames&) {
        return names_of_disturbances();
      });
  arguments.positional("VALUE", value, "Default 1; 0 clears")
      .completed_by(complete_one_of({"0", "1"}));
  arguments.then([this, &kind, &value] {
    inputs = inputs_of(kind, value.empty() ? "1" : value);
  });
  arguments.option("--for", "T", duration, "Clear after this drive time", parse_duration);
}

void DisturbCommand::check_objects() const {
  for (const Disturbance& input : inputs) check_value_written(input.object, input.value);
}

Outcome DisturbCommand::run(CommandContext& context) const {
  auto found = context.axes.axis(axis);
  if (!found) return found.outcome();
  if (Outcome set = set_inputs(context, *found, inputs); !set || !duration) return set;
  context.progress.axis(*found, context.axes.label_of(found->id()), "disturbed");
  const auto waited = context.session.wait(found->id().bench, *duration);
  context.progress.end();
  // Cleared in any case: an interrupt does not mean a disturbance without end.
  std::vector<Disturbance> cleared = inputs;
  for (Disturbance& input : cleared) input.value = 0;
  if (Outcome set = set_inputs(context, *found, cleared); !set) return set;
  return waited.outcome();
}

extern const CommandRow kDisturb =
    row_of<DisturbCommand>({.name = "disturb",
                            .group = CommandGroup::bench,
                            .summary = "Set a test-bench input: a load, a fault, a switch",
                            .example = "disturb 1.1 load_torque 1500 --for 200ms"});

}  // namespace vdrive::tool
