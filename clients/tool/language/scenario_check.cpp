// SPDX-License-Identifier: Apache-2.0
#include "language/scenario_check.hpp"

#include "base/usage_error.hpp"
#include "vdrive/text.hpp"

#include <type_traits>
#include <variant>

namespace vdrive::tool {
namespace {

ObjectRow checked_row(const ObjectName& object) {
  if (const auto row = object.row()) return *row;
  throw UsageError(in_quotes(object.text) + " is not an object of the dictionary" +
                   object_suggestion(object.text) + "; 'vdrive dictionary' lists all objects");
}

std::string range_text(ObjectRow row) {
  const ObjectDescription& object = describe(row);
  return std::string(object.variable_name) + " has " + std::to_string(object.lower_limit) + " to " +
         std::to_string(object.upper_limit);
}

void check_value_written(const ObjectName& object, std::int64_t value) {
  const ObjectRow row = checked_row(object);
  const AbortCode code = check_write(row, value);
  if (code == AbortCode::none) return;
  if (code == AbortCode::write_of_read_only_object) {
    throw UsageError(in_quotes(object.text) + " is read-only");
  }
  throw UsageError(std::to_string(value) + " is out of range: " + range_text(row));
}

void check_expectation(const ExpectCommand& expect) {
  const ObjectRow row = checked_row(expect.object);
  // Under a mask, and with a tolerance, a value beyond the range may match all the same.
  if (expect.mask || expect.tolerance || expect.quantity) return;
  const ObjectDescription& object = describe(row);
  // Of an unequal value there is always another one; the other comparisons hold at an end of the
  // range, or nowhere.
  const bool is_possible =
      expect.comparison == Comparison::not_equal || expect.accepts(object.lower_limit) ||
      expect.accepts(object.upper_limit) ||
      (expect.comparison == Comparison::equal && expect.value >= object.lower_limit &&
       expect.value <= object.upper_limit);
  if (is_possible) return;
  const std::string sign =
      expect.comparison == Comparison::equal ? "" : std::string(to_string(expect.comparison)) + " ";
  throw UsageError(sign + std::to_string(expect.value) + " is never reached: " + range_text(row));
}

/// A command without objects.
template <typename AnyCommand>
void check(const AnyCommand& /*command*/) {}

void check(const ReadCommand& command) {
  for (const ObjectName& object : command.objects) static_cast<void>(checked_row(object));
}

void check(const WriteCommand& command) {
  // With a unit the value is known once the axis is: the drive refuses it then.
  if (!command.quantity) check_value_written(command.object, command.value);
}

void check(const DisturbCommand& command) {
  for (const Disturbance& input : command.inputs) check_value_written(input.object, input.value);
}

void check(const ExpectCommand& command) {
  check_expectation(command);
}

void check(const AwaitCommand& command) {
  if (command.expectation) check_expectation(*command.expectation);
}

}  // namespace

void check_objects(const Command& command) {
  std::visit(
      [](const auto& word) {
        check(word);
      },
      command);
}

}  // namespace vdrive::tool
