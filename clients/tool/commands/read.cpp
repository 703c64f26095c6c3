// SPDX-License-Identifier: Apache-2.0
#include "commands/read.hpp"

#include "execution/command_context.hpp"
#include "language/arguments.hpp"
#include "values/object_check.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"

#include <utility>

namespace vdrive::tool {
namespace {

using client::Outcome;

Json json_of_reading(const client::Axis& axis, const ObjectName& object,
                     const client::ObjectReading& reading, std::uint64_t tick) {
  Json json = object_json(axis.id(), object);
  if (reading.code == AbortCode::none) {
    json["value"] = reading.value;
    add_in_unit(json, object.row(), axis.unit(), "value", reading.value);
  } else {
    json["code"] = hex(wire_code(reading.code), 8);
    const std::string advice = object.address ? advice_on(*object.address, reading.code) : "";
    json["message"] =
        std::string(vdrive::describe(reading.code)) + (advice.empty() ? "" : ", " + advice);
  }
  json["tick"] = tick;
  return json;
}

Outcome print_reading(const CommandContext& context, const client::Axis& axis,
                      const ObjectName& object, const client::ObjectReading& reading,
                      std::uint64_t tick) {
  const bool is_read = reading.code == AbortCode::none;
  Terminal& terminal = context.output.terminal;
  if (context.output.is_json) {
    terminal.print(to_line(json_of_reading(axis, object, reading, tick)));
  } else if (is_read) {
    terminal.print(
        reading_text(context.axes.label_of(axis.id()), object, reading.value, axis.unit()));
  }
  if (is_read) return {};
  if (!object.address) return unknown_object(axis.id(), object);
  const std::string advice = advice_on(*object.address, reading.code);
  return Outcome::refused(wire_code(reading.code), "read of " + object.text + " of axis " +
                                                       to_string(axis.id()) + " refused" +
                                                       (advice.empty() ? "" : ", " + advice));
}

/// @return the readings of the objects that have an address.
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

}  // namespace vdrive::tool
