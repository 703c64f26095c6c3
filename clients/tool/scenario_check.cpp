// SPDX-License-Identifier: Apache-2.0
#include "scenario_check.hpp"

#include "usage_error.hpp"
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
  if (expect.mask || expect.tolerance) return;
  const ObjectDescription& object = describe(row);
  if (expect.value >= object.lower_limit && expect.value <= object.upper_limit) return;
  throw UsageError(std::to_string(expect.value) + " is never reached: " + range_text(row));
}

}  // namespace

void check_objects(const Command& command) {
  std::visit(
      [](const auto& word) {
        using Word = std::decay_t<decltype(word)>;
        if constexpr (std::is_same_v<Word, ReadCommand>) {
          for (const ObjectName& object : word.objects) static_cast<void>(checked_row(object));
        } else if constexpr (std::is_same_v<Word, WriteCommand>) {
          check_value_written(word.object, word.value);
        } else if constexpr (std::is_same_v<Word, DisturbCommand>) {
          for (const Disturbance& input : word.inputs) {
            check_value_written(input.object, input.value);
          }
        } else if constexpr (std::is_same_v<Word, ExpectCommand>) {
          check_expectation(word);
        }
      },
      command);
}

}  // namespace vdrive::tool
