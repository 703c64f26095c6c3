// SPDX-License-Identifier: Apache-2.0
#include "commands/objects.hpp"

#include "base/usage_error.hpp"
#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "output/live_view.hpp"
#include "vdrive/client/disturbance.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;

/// Prints a note if the limits have no effect: the drive accepts every value of 607Dh, but uses the
/// limits only if 3535h enables them and lower < upper.
void note_limits(const CommandContext& context, const client::Axis& axis, ObjectAddress written) {
  using namespace vdrive::literals;
  const std::array limits{kObjectRows["app_position_limit_switch"_object].address,
                          kObjectRows["user_position_lower_limit"_object].address,
                          kObjectRows["user_position_upper_limit"_object].address};
  if (std::ranges::find(limits, written) == limits.end()) return;
  const auto values = axis.read(limits);
  if (!values) return;  // the write itself has succeeded
  const std::int64_t lower = values->objects[1].value;
  const std::int64_t upper = values->objects[2].value;
  if (values->objects[0].value == 0) {
    if (written == limits[0]) return;
    context.output.terminal.print_error(
        "vdrive: the software limits are disabled: set app_position_limit_switch (3535h) = 1 to "
        "enable them");
  } else if (lower >= upper) {
    context.output.terminal.print_error(
        "vdrive: the software limits are not in force: user_position_lower_limit (607Dh:1) = " +
        quantity_text(lower, Dimension::position, axis.unit()) +
        " is not below user_position_upper_limit (607Dh:2) = " +
        quantity_text(upper, Dimension::position, axis.unit()));
  }
}

/// Prints the written value and the tick at which it takes effect.
void print_written(Record record, const client::Result<std::uint64_t>& tick,
                   const CommandContext& context) {
  const Outcome outcome = context.axes.named(tick.outcome());
  add_outcome(record, outcome);
  if (tick) record.push_back({"tick", *tick, "in force at tick " + std::to_string(*tick)});
  print_answer(record, outcome, context.output);
}

/// @return the tick at which the value takes effect.
client::Result<std::uint64_t> write_unprinted(CommandContext& context, client::Axis& axis,
                                              const ObjectName& object, std::int64_t value) {
  if (!object.address) return unknown_object(axis.id(), object);
  auto tick = axis.write(*object.address, value);
  if (!tick) return tick;
  context.judge.note_write(axis.id(), *tick);
  context.changes.note_write(axis, *object.address, value);
  return tick;
}

/// Writes an object, and prints the value and the tick at which it takes effect.
Outcome write_object(CommandContext& context, client::Axis& axis, const ObjectName& object,
                     std::int64_t value) {
  constexpr std::uint16_t kTarget = 0x607A;
  const auto tick = write_unprinted(context, axis, object, value);
  Record record = object_fields(axis.id(), object);
  record.push_back(
      {"value", value,
       reading_text(context.axes.label_of(axis.id()), object, value, axis.unit()) + ","});
  add_in_unit(record, object.row(), axis.unit(), "value", value);
  print_written(std::move(record), tick, context);
  if (!tick) return tick.outcome();
  if (context.live_view != nullptr && object.address->index == kTarget) {
    context.live_view->aim(axis.id(), value);
  }
  if (!context.output.is_quiet) note_limits(context, axis, *object.address);
  return {};
}

Outcome print_reading(const CommandContext& context, const client::Axis& axis,
                      const ObjectName& object, const client::ObjectReading& reading,
                      std::uint64_t tick) {
  const bool is_read = reading.code == AbortCode::none;
  std::string advice =
      is_read || !object.address ? std::string() : advice_on(*object.address, reading.code);
  if (!advice.empty()) advice.insert(0, ", ");
  Record record = object_fields(axis.id(), object);
  if (is_read) {
    record.push_back(
        {"value", reading.value,
         reading_text(context.axes.label_of(axis.id()), object, reading.value, axis.unit())});
    add_in_unit(record, object.row(), axis.unit(), "value", reading.value);
  } else {
    record.push_back({"code", hex(wire_code(reading.code), 8)});
    record.push_back({"message", std::string(vdrive::describe(reading.code)) + advice});
  }
  record.push_back({"tick", tick});
  print(record, context.output);
  if (is_read) return {};
  if (!object.address) return unknown_object(axis.id(), object);
  return Outcome::refused(wire_code(reading.code), "read of " + object.text + " of axis " +
                                                       to_string(axis.id()) + " refused" + advice);
}

/// @return the readings of those objects that have an address.
client::Result<client::Readings> read_all(const client::Axis& axis,
                                          const std::vector<ObjectName>& objects) {
  std::vector<ObjectAddress> addresses;
  for (const ObjectName& object : objects) {
    if (object.address) addresses.push_back(*object.address);
  }
  if (addresses.empty()) return client::Readings();
  return axis.read(addresses);
}

}  // namespace

void ReadCommand::declare(Arguments& arguments) {
  arguments.axis(axis);
  arguments.positionals("OBJECT", objects, "0x6041, 0x607D:1 or a variable_name", parse_objects)
      .required()
      .completed_by(complete_object);
}

void ReadCommand::check_objects() const {
  for (const ObjectName& object : objects) static_cast<void>(checked_row(object));
}

Outcome ReadCommand::run(CommandContext& context) const {
  const auto found = context.axes.axis(axis);
  if (!found) return found.outcome();
  const auto readings = read_all(*found, objects);
  if (!readings) return readings.outcome();
  Outcome outcome;
  auto next = readings->objects.begin();
  for (const ObjectName& object : objects) {
    const client::ObjectReading reading =
        object.address ? *next++ : client::ObjectReading{{}, AbortCode::object_does_not_exist, 0};
    Outcome printed = print_reading(context, *found, object, reading, readings->tick);
    if (outcome) outcome = std::move(printed);
  }
  return outcome;
}

extern const CommandRow kRead =
    row_of<ReadCommand>({.name = "read",
                         .group = CommandGroup::parameters,
                         .summary = "Read objects",
                         .example = "read 1.1 0x6041 position_demand_value"});

namespace {

/// @return the values of an object that allows only a few.
std::vector<std::string> few_values_of(const std::string& object) {
  const auto row = parse_object(object).row();
  if (!row) return {};
  std::vector<std::string> values;
  for (const std::int64_t value : few_values(*row)) values.push_back(std::to_string(value));
  return values;
}

}  // namespace

void WriteCommand::declare(Arguments& arguments) {
  arguments.axis(axis);
  arguments.positional("OBJECT", object, "0x6040, 0x607D:1 or a variable_name", parse_object)
      .completed_by(complete_object);
  arguments
      .positional(
          "VALUE", value,
          "Decimal, or hex as the type's two's complement; positions, speeds, ramps and jerks also "
          "with a unit",
          [this](const std::string& text) {
            quantity = parse_quantity(text, object);
            return quantity ? 0 : parse_value(text, object);
          })
      .completed_by([](auto before, const BenchNames&) {
        return few_values_of(before[1]);
      });
  arguments.take_over(take_over);
}

void WriteCommand::check_objects() const {
  // A value with a unit can be converted only when the axis is known; the drive then refuses a bad
  // value.
  if (!quantity) check_value_written(object, value);
}

void WriteCommand::check_units(const CommandContext& context, const client::Axis& written) const {
  if (quantity) static_cast<void>(context.axes.user_units(written, *quantity));
}

client::Outcome WriteCommand::run(CommandContext& context) const {
  auto found = context.axes.axis_to_command(axis, take_over);
  if (!found) return found.outcome();
  return write_object(context, *found, object,
                      quantity ? context.axes.user_units(*found, *quantity) : value);
}

extern const CommandRow kWrite = row_of<WriteCommand>({.name = "write",
                                                       .group = CommandGroup::parameters,
                                                       .summary = "Write an object",
                                                       .example = "write 1.1 0x607A 0xFFFFD8F0"});

namespace {

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

/// Clears the inputs, and prints one line, or one JSON object, for all of them.
Outcome clear_all(CommandContext& context, client::Axis& axis,
                  const std::vector<Disturbance>& inputs) {
  client::Result<std::uint64_t> tick = std::uint64_t{0};
  for (const Disturbance& input : inputs) {
    tick = write_unprinted(context, axis, input.object, 0);
    if (!tick) break;
  }
  print_written({{"axis", to_string(axis.id()), context.axes.label_of(axis.id())},
                 {"command", "disturb"},
                 {"inputs", inputs.size(), "all test inputs cleared,"}},
                tick, context);
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
  // Cleared even after an interrupt, so that no disturbance remains.
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
