// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "values/value.hpp"

#include <cstdint>
#include <string>

namespace vdrive::tool {

/// What the dictionary alone shows of the objects of a scenario, before anything moves.

/// @return the row of the object.
/// @throws UsageError for an object that does not exist.
ObjectRow checked_row(const ObjectName& object);

/// @throws UsageError for an object that does not exist or is read-only, and for a value out of its
///         range.
void check_value_written(const ObjectName& object, std::int64_t value);

/// @return such as "motor_max_speed_rpm has 1 to 4294967295".
[[nodiscard]] std::string range_text(ObjectRow row);

}  // namespace vdrive::tool
