// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "output/record.hpp"
#include "terminal/terminal.hpp"
#include "values/value.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// The name of an axis and its user units.
struct AxisLabel {
  std::string name;
  client::Unit unit;
  std::string bench{};                         ///< name of its bench, if several are shown
  std::optional<client::SessionName> owner{};  ///< session that controls it, if known
};

/// The status of an axis as in `status` and `watch`.
[[nodiscard]] Json status_json(const client::AxisSnapshot& axis, const AxisLabel& label);

/// The same as several lines of text.
[[nodiscard]] std::vector<std::string> status_text(const client::AxisSnapshot& axis,
                                                   const AxisLabel& label);

/// The same as one line of text. @param label name of the axis
[[nodiscard]] std::string status_line(const client::AxisSnapshot& axis, const std::string& label,
                                      const client::Unit& unit);

/// As status_line(), at the end of a motion: without the speed, which has dropped to a remainder
/// within the window.
[[nodiscard]] std::string arrival_line(const client::AxisSnapshot& axis, const std::string& label,
                                       const client::Unit& unit);

/// @return the state, the error in 603Fh, and the bits of the statusword that are not constant 1,
///         such as "Fault 0x8611 following error" or "Operation enabled: target reached".
[[nodiscard]] std::string state_text(const client::AxisSnapshot& axis);

/// @return the colour of an axis: red in a fault, yellow with a warning or in a quick stop.
[[nodiscard]] std::optional<Color> color_of(const client::AxisSnapshot& axis);

/// @param code a value of 603Fh
/// @return such as "0x8611 following error".
[[nodiscard]] std::string error_text(std::uint16_t code);

/// @return tenths of a percent as text, such as "12.5 %".
[[nodiscard]] std::string per_mille_text(int value);

/// An axis as in `list`. @param owner session that controls it, if known
[[nodiscard]] Record list_record(const client::BenchInfo& bench, const client::AxisInfo& info,
                                 const client::AxisSnapshot& axis,
                                 const std::optional<client::SessionName>& owner);

/// The fields that identify an object in `read` and `write`.
[[nodiscard]] Record object_fields(const client::AxisId& axis, const ObjectName& object);

/// @return the object and its value as text, such as "1.1 position = 90.00 deg".
[[nodiscard]] std::string reading_text(const std::string& label, const ObjectName& object,
                                       std::int64_t value, const client::Unit& unit);

/// Adds a position, speed, ramp or jerk in the unit of the axis: `unit`, such as "mm/s3", and the
/// value as `key` with "_in_unit". Adds nothing for other objects.
void add_in_unit(Record& record, std::optional<ObjectRow> row, const client::Unit& unit,
                 std::string_view key, std::int64_t value);

/// @return the refusal of an object without a known address.
[[nodiscard]] client::Outcome unknown_object(const client::AxisId& axis, const ObjectName& object);

}  // namespace vdrive::tool
