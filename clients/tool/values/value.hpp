// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"
#include "vdrive/quantity.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

using Duration = std::chrono::nanoseconds;

/// An object as the user has typed it.
struct ObjectName {
  std::string text;
  std::optional<ObjectAddress> address;  ///< none: a variable_name that no object has

  /// @return its row, none if the object does not exist.
  [[nodiscard]] std::optional<ObjectRow> row() const;

  /// @return whether this name, in a list of objects, includes the row at `other`: an index without
  ///         a sub-index stands for all of its sub-indices.
  [[nodiscard]] bool covers(ObjectAddress other) const;
};

/// @param text an address such as `0x6041` (sub-index 0), `0x607D:1` or `607Dh:1` (`parse_address`
///        of the core), a variable_name, the name of the object in the standard (CiA 402), such as
///        `statusword`, or a short name of the tool, such as `velocity`
/// @throws UsageError for anything else. The drive decides whether the object exists.
[[nodiscard]] ObjectName parse_object(std::string_view text);

/// @return the objects with these names.
[[nodiscard]] std::vector<ObjectName> parse_objects(const std::vector<std::string>& texts);

/// @param name not the name of an object
/// @return " (did you mean 'x'?)" with the nearest name, or nothing if none is near.
[[nodiscard]] std::string object_suggestion(std::string_view name);

/// Numbers and durations as in vdrive/number_text.hpp, with limits and error messages for users.

/// @param text decimal, negative, or hexadecimal as the two's complement of `type`: 0xFFFFD8F0 is
///        -10000 as INTEGER32
/// @throws UsageError with text and limits if it is not an integer or out of the range of `type`.
[[nodiscard]] std::int64_t parse_value(std::string_view text, DataType type);

/// As above, by the type of an object, or as any 32-bit number if the object does not exist.
[[nodiscard]] std::int64_t parse_value(std::string_view text, const ObjectName& object);

/// @return a value for output: words in hex and decimal, and a position, speed, ramp or jerk also
///         in the unit of the axis.
[[nodiscard]] std::string value_text(const ObjectName& object, std::int64_t value,
                                     const Unit& unit);

/// @param highest at most the highest std::int64_t
/// @throws UsageError naming `what` if it is not an integer from 0 to `highest`.
[[nodiscard]] std::uint64_t parse_number(std::string_view text, std::string_view what,
                                         std::uint64_t highest);

/// @param text such as 500us, 20ms, 1.5s or 2min; without a unit in seconds
/// @throws UsageError for anything else, and for more than kLongestDuration.
[[nodiscard]] Duration parse_duration(std::string_view text);

/// @throws UsageError naming `what` if it is not a finite number.
[[nodiscard]] double parse_real(std::string_view text, std::string_view what);

/// @return the row of the object.
/// @throws UsageError if the object does not exist.
ObjectRow checked_row(const ObjectName& object);

/// @throws UsageError for an object that does not exist or is read-only, and for a value out of
///         range.
void check_value_written(const ObjectName& object, std::int64_t value);

/// @return such as "motor_max_speed_rpm has 1 to 4294967295".
[[nodiscard]] std::string range_text(ObjectRow row);

}  // namespace vdrive::tool
