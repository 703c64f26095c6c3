// SPDX-License-Identifier: Apache-2.0
#include "values/object_check.hpp"

#include "base/usage_error.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/text.hpp"

namespace vdrive::tool {

ObjectRow checked_row(const ObjectName& object) {
  if (const auto row = object.row()) return *row;
  const std::string advice =
      object.address ? advice_on(*object.address, check_address(*object.address)) : "";
  throw UsageError(in_quotes(object.text) + " is not an object of the dictionary" +
                   object_suggestion(object.text) +
                   (advice.empty() ? "; 'vdrive dictionary' lists all objects" : ": " + advice));
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

std::string range_text(ObjectRow row) {
  const ObjectDescription& object = describe(row);
  return std::string(object.variable_name) + " has " + values_text(row);
}

}  // namespace vdrive::tool
