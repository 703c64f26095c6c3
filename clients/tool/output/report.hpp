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

/// What an axis is called, and what its user units are.
struct AxisFace {
  std::string name;
  client::Unit unit;
  std::string bench{};                         ///< name of its bench, for a view of several benches
  std::optional<client::SessionName> owner{};  ///< who holds it, where it is known
};

/// One axis as `status` and `watch` show it.
[[nodiscard]] Json status_json(const client::AxisSnapshot& axis, const AxisFace& face);

/// The same as some lines of text.
[[nodiscard]] std::vector<std::string> status_text(const client::AxisSnapshot& axis,
                                                   const AxisFace& face);

/// The same as one line of text. @param label what the axis is called
[[nodiscard]] std::string status_line(const client::AxisSnapshot& axis, const std::string& label,
                                      const client::Unit& unit);

/// The same of an axis at the end of a motion: its speed is what is left within the window.
[[nodiscard]] std::string arrival_line(const client::AxisSnapshot& axis, const std::string& label,
                                       const client::Unit& unit);

/// @return the state, the error that 603Fh shows, and the bits of the statusword that are not
///         always 1, such as "Fault 0x8611 following error" or "Operation enabled: target reached".
[[nodiscard]] std::string state_text(const client::AxisSnapshot& axis);

/// @return the colour of an axis: red in a fault, yellow with a warning or in a quick stop.
[[nodiscard]] std::optional<Color> color_of(const client::AxisSnapshot& axis);

/// @param code a value of 603Fh
/// @return such as "0x8611 following error".
[[nodiscard]] std::string error_text(std::uint16_t code);

/// @return tenths of a percent as "12.5 %".
[[nodiscard]] std::string per_mille_text(int value);

/// One axis as `list` shows it. @param owner who holds it, where it is known
[[nodiscard]] Record list_record(const client::BenchInfo& bench, const client::AxisInfo& info,
                                 const client::AxisSnapshot& axis,
                                 const std::optional<client::SessionName>& owner);

/// The fields that name an object, as `read` and `write` show it.
[[nodiscard]] Record object_fields(const client::AxisId& axis, const ObjectName& object);

/// @return the object and its value as text, such as "1.1 position = 90.00 deg".
[[nodiscard]] std::string reading_text(const std::string& label, const ObjectName& object,
                                       std::int64_t value, const client::Unit& unit);

/// Adds a value of a position, speed, ramp or jerk in the unit of the axis: `unit`, such as
/// "mm/s3", and the value as `key` with "_in_unit". Nothing for other objects.
void add_in_unit(Record& record, std::optional<ObjectRow> row, const client::Unit& unit,
                 std::string_view key, std::int64_t value);

/// @return the refusal of an object that no address is known of.
[[nodiscard]] client::Outcome unknown_object(const client::AxisId& axis, const ObjectName& object);

}  // namespace vdrive::tool
