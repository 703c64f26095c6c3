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
  for (const Disturbance& input : inputs) {
    if (Outcome written = write_object(context, *found, input.object, input.value); !written) {
      return written;
    }
  }
  if (!duration) return {};
  const auto waited = context.session.wait(found->id().bench, *duration);
  // Cleared in any case: an interrupt does not mean a disturbance without end.
  for (const Disturbance& input : inputs) {
    if (Outcome written = write_object(context, *found, input.object, 0); !written) return written;
  }
  return waited.outcome();
}

extern const CommandRow kDisturb =
    row_of<DisturbCommand>({.name = "disturb",
                            .summary = "Set a test-bench input: a load, a fault, a switch",
                            .example = "disturb 1.1 load_torque 1500 --for 200ms"});

}  // namespace vdrive::tool
