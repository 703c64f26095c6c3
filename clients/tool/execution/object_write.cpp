// SPDX-License-Identifier: Apache-2.0
#include "execution/object_write.hpp"

#include "vdrive/dictionary/object_table.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace vdrive::tool {
namespace {

using client::Outcome;

/// The drive takes every value of 607Dh, and uses them with 3535h and in the right order only.
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
    context.output.terminal.complain(
        "vdrive: the software limits are off: app_position_limit_switch (3535h) = 1 switches them "
        "on");
  } else if (lower >= upper) {
    context.output.terminal.complain(
        "vdrive: the software limits are not in force: user_position_lower_limit (607Dh:1) = " +
        quantity_text(lower, Dimension::position, axis.unit()) +
        " is not below user_position_upper_limit (607Dh:2) = " +
        quantity_text(upper, Dimension::position, axis.unit()));
  }
}

void print_write(const CommandContext& context, const client::Axis& axis, const ObjectName& object,
                 std::int64_t value, const client::Result<std::uint64_t>& tick) {
  const Output& output = context.output;
  if (output.is_quiet) return;
  if (output.is_json) {
    Json json = object_json(axis.id(), object);
    json["value"] = value;
    add_in_unit(json, object.row(), axis.unit(), "value", value);
    add_outcome(json, context.axes.named(tick.outcome()));
    if (tick) json["tick"] = *tick;
    output.terminal.print(to_line(json));
  } else if (tick) {
    output.terminal.print(
        reading_text(context.axes.label_of(axis.id()), object, value, axis.unit()) +
        ", in force at tick " + std::to_string(*tick));
  }
}

}  // namespace

client::Result<std::uint64_t> write_unprinted(CommandContext& context, client::Axis& axis,
                                              const ObjectName& object, std::int64_t value) {
  if (!object.address) return unknown_object(axis.id(), object);
  auto tick = axis.write(*object.address, value);
  if (!tick) return tick;
  context.judge.note_write(axis.id(), *tick);
  context.changes.note_write(axis, *object.address, value);
  return tick;
}

Outcome write_object(CommandContext& context, client::Axis& axis, const ObjectName& object,
                     std::int64_t value) {
  constexpr std::uint16_t kTarget = 0x607A;
  const auto tick = write_unprinted(context, axis, object, value);
  print_write(context, axis, object, value, tick);
  if (!tick) return tick.outcome();
  if (context.on_aim && object.address->index == kTarget) context.on_aim(axis.id(), value);
  if (!context.output.is_quiet) note_limits(context, axis, *object.address);
  return {};
}

}  // namespace vdrive::tool
