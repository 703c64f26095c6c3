// SPDX-License-Identifier: Apache-2.0
#include "commands/write.hpp"

#include "execution/command_context.hpp"
#include "execution/object_write.hpp"
#include "language/arguments.hpp"
#include "values/object_check.hpp"
#include "vdrive/dictionary/dictionary.hpp"

namespace vdrive::tool {
namespace {

/// @return the values of an object that takes few of them.
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
  // With a unit the value is known once the axis is: the drive refuses it then.
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

}  // namespace vdrive::tool
