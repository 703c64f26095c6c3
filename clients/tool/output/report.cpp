// SPDX-License-Identifier: Apache-2.0
#include "output/report.hpp"

#include "terminal/columns.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/quantity.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace vdrive::tool {
namespace {

template <typename... Arguments>
std::string formatted(const char* format, Arguments... arguments) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, arguments...);
  return text.data();
}

std::string holder_text(std::uint64_t session, const std::optional<client::SessionName>& name) {
  if (session == 0) return "free";
  return name ? client::owner_text(session, name) : session_text(session);
}

}  // namespace

std::string error_text(std::uint16_t code) {
  return hex(code, 4) + " " + std::string(vdrive::describe(static_cast<ErrorCode>(code)));
}

std::string per_mille_text(int value) {
  return formatted("%.1f %%", value / 10.0);
}

Json status_json(const client::AxisSnapshot& axis, const AxisLabel& label) {
  return recording::status_json(axis, label.name, label.unit);
}

std::vector<std::string> status_text(const client::AxisSnapshot& axis, const AxisLabel& label) {
  const auto in_unit = [&label](std::int32_t user_units) {
    return escaped(position_text(user_units, label.unit));
  };
  const AxisStatus& status = axis.status;
  std::vector<std::string> lines;
  lines.push_back(to_string(axis.id) + " " + escaped(label.name));
  lines.push_back("  statusword  " +
                  client::describe_statusword(status.ds402_statusword, axis.mode()));
  lines.push_back("  mode        " + std::to_string(status.op_mode_actual) + " " +
                  std::string(to_string(axis.mode())));
  lines.push_back(formatted("  position    %d UU, demand %d, error %d",
                            status.load_position_actual_value, status.position_demand_value,
                            status.load_position_error_value));
  lines.push_back("              " + in_unit(status.load_position_actual_value) + ", demand " +
                  in_unit(status.position_demand_value) + ", error " +
                  in_unit(status.load_position_error_value));
  lines.push_back(formatted("  velocity    %d UU/s, demand %d", status.load_velocity_actual_value,
                            status.velocity_demand_value));
  lines.push_back("              " + in_unit(status.load_velocity_actual_value) + "/s, demand " +
                  in_unit(status.velocity_demand_value) + "/s");
  lines.push_back("  torque      " + per_mille_text(status.torque_actual_value) +
                  " of rated, current " + per_mille_text(status.current_actual_value));
  lines.push_back("  error       " +
                  (status.error_code == 0 ? std::string("none") : error_text(status.error_code)));
  lines.push_back("  owner       " + holder_text(axis.owner_session, label.owner));
  lines.push_back("  tick        " + std::to_string(axis.tick));
  return lines;
}

std::string state_text(const client::AxisSnapshot& axis) {
  constexpr std::uint16_t kUsual = Statusword::kVoltageEnabled | Statusword::kRemote;
  const std::uint16_t word = axis.status.ds402_statusword;
  std::string text(to_string(axis.state()));
  if (axis.status.error_code != 0) text += " " + error_text(axis.status.error_code);
  // Bits 4 and 9 are normally 1, so the line shows when they are not.
  std::string_view separator = ": ";
  if ((word & kUsual) != kUsual) {
    text.append(separator).append("no voltage or not remote");
    separator = ", ";
  }
  for (const std::string_view name :
       client::statusword_flags(static_cast<std::uint16_t>(word & ~kUsual), axis.mode())) {
    text.append(separator).append(name);
    separator = ", ";
  }
  return text;
}

namespace {

/// @return such as "1.1        1024 UU   90.00 deg".
std::string place_text(const client::AxisSnapshot& axis, const std::string& label,
                       const client::Unit& unit) {
  constexpr std::size_t kUsualWidth = 12;
  const std::int32_t position = axis.status.load_position_actual_value;
  return padded(label, 4) + formatted(" %10d UU ", position) +
         aligned_right(escaped(position_text(position, unit)), kUsualWidth);
}

}  // namespace

std::string status_line(const client::AxisSnapshot& axis, const std::string& label,
                        const client::Unit& unit) {
  constexpr std::size_t kUsualWidth = 14;
  const std::int32_t velocity = axis.status.load_velocity_actual_value;
  return place_text(axis, label, unit) + formatted(" %8d UU/s ", velocity) +
         aligned_right(escaped(position_text(velocity, unit)) + "/s", kUsualWidth) +
         formatted("  0x%03X ", unsigned{axis.status.ds402_statusword}) + state_text(axis);
}

std::string arrival_line(const client::AxisSnapshot& axis, const std::string& label,
                         const client::Unit& unit) {
  return place_text(axis, label, unit) +
         formatted("  0x%03X ", unsigned{axis.status.ds402_statusword}) + state_text(axis);
}

std::optional<Color> color_of(const client::AxisSnapshot& axis) {
  const PowerState state = axis.state();
  if (is_fault(state)) return Color::red;
  if (state == PowerState::quick_stop_active || axis.shows(Statusword::kWarning)) {
    return Color::yellow;
  }
  return std::nullopt;
}

Record list_record(const client::BenchInfo& bench, const client::AxisInfo& info,
                   const client::AxisSnapshot& axis,
                   const std::optional<client::SessionName>& owner) {
  const std::string id = to_string(info.id);
  const std::string state(to_string(axis.state()));
  const std::uint16_t statusword = axis.status.ds402_statusword;
  return {{"axis", id, formatted("  %-7s", id.c_str())},
          {"bench", bench.number},
          {"bench_name", bench.name},
          {"clock", to_string(bench.clock_mode)},
          {"period_us", bench.period.count()},
          {"host", bench.host},
          {"version", bench.service_version},
          {"name", info.name, formatted("%-20s", escaped(info.name).c_str())},
          {"state", state, formatted("%-24s", state.c_str())},
          {"statusword", statusword, formatted("0x%03X ", unsigned{statusword})},
          {"owner", session_json(axis.owner_session), holder_text(axis.owner_session, owner)},
          {"owner_name", name_json(owner)},
          {"tick", axis.tick}};
}

Record object_fields(const client::AxisId& axis, const ObjectName& object) {
  const auto& address = object.address;
  const auto row = object.row();
  const Json unknown = address ? Json(nullptr) : Json(object.text);
  return {{"axis", to_string(axis)},
          {"index", address ? Json(hex(address->index, 4)) : Json(nullptr)},
          {"subindex", address ? Json(address->subindex) : Json(nullptr)},
          {"name", row ? Json(describe(*row).variable_name) : unknown}};
}

std::string reading_text(const std::string& label, const ObjectName& object, std::int64_t value,
                         const client::Unit& unit) {
  const auto row = object.row();
  std::string text = label + " " + object.text;
  if (row && describe(*row).variable_name != object.text) {
    text += " " + std::string(describe(*row).variable_name);
  }
  text += " = " + value_text(object, value, unit);
  if (object.address && object.address->index == 0x6041) {
    text += " " + std::string(to_string(decode_power_state(static_cast<std::uint16_t>(value))));
  }
  return text;
}

void add_in_unit(Record& record, std::optional<ObjectRow> row, const client::Unit& unit,
                 std::string_view key, std::int64_t value) {
  const auto dimension = row ? dimension_of(*row) : std::nullopt;
  if (!dimension) return;
  record.push_back({"unit", unit_name(*dimension, unit)});
  record.push_back(
      {std::string(key) + "_in_unit", client::from_user_units(static_cast<double>(value), unit)});
}

client::Outcome unknown_object(const client::AxisId& axis, const ObjectName& object) {
  return client::Outcome::refused(wire_code(AbortCode::object_does_not_exist),
                                  "axis " + to_string(axis) + " has no object " +
                                      in_quotes(object.text) + object_suggestion(object.text));
}

}  // namespace vdrive::tool
