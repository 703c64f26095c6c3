// SPDX-License-Identifier: Apache-2.0
#include "output/axis_description.hpp"

#include "terminal/columns.hpp"
#include "vdrive/cia402/error_code.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/quantity.hpp"
#include "vdrive/text.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace vdrive::tool {
namespace {

using namespace vdrive::literals;

constexpr ObjectRow kNewestError = "error_history_1"_object;
constexpr ObjectRow kMotorType = "motor_type"_object;

/// Objects of the motor and the gear, in the order of the description.
constexpr std::array kModelObjects{
    kMotorType,
    "motor_rated_torque"_object,
    "motor_rated_current"_object,
    "motor_max_speed_rpm"_object,
    "gear_ratio_numerator"_object,
    "gear_ratio_denominator"_object,
};

/// @return whether a user may have changed the object from its default. The count of the history
///         (1003h:0) does not qualify: users write it only to clear the history, and every fault
///         changes it.
bool can_differ(const ObjectDescription& object) {
  return object.access == Access::read_write && object.change != Change::memory &&
         object.change != Change::history;
}

std::optional<std::int64_t> value_in(const client::Readings& readings, ObjectRow row) {
  const auto found =
      std::ranges::find(readings.objects, describe(row).address, &client::ObjectReading::object);
  if (found == readings.objects.end() || found->code != AbortCode::none) return std::nullopt;
  return found->value;
}

std::string number_or_unknown(const client::Readings& readings, ObjectRow row) {
  const auto value = value_in(readings, row);
  return value ? std::to_string(*value) : "unknown";
}

/// Writable objects whose value is not their default, and those that were refused.
std::vector<client::ObjectReading> differing(const client::Readings& readings) {
  std::vector<client::ObjectReading> objects;
  for (const client::ObjectReading& reading : readings.objects) {
    const auto row = find_object(reading.object);
    if (!row || !can_differ(describe(*row))) continue;
    const bool is_default =
        reading.code == AbortCode::none && reading.value == describe(*row).default_value;
    if (!is_default) objects.push_back(reading);
  }
  return objects;
}

std::vector<std::string> names_of_modes(std::uint32_t supported_drive_modes) {
  std::vector<std::string> names;
  for (const OperatingModeRow& row : kOperatingModes) {
    if (row.mode == OperatingMode::none) continue;
    const std::uint32_t bit = 1U << (static_cast<unsigned>(row.mode) - 1U);
    if ((supported_drive_modes & bit) != 0) names.emplace_back(row.name);
  }
  return names;
}

Json fault_json(const AxisDescription& described) {
  const auto code = last_fault_of(described.status, described.readings);
  if (!code) return nullptr;
  return {{"code", *code},
          {"name", vdrive::describe(static_cast<ErrorCode>(*code))},
          {"is_present", described.status.status.error_code == *code},
          {"tick", described.fault_tick ? Json(*described.fault_tick) : Json(nullptr)}};
}

Json model_json(const AxisDescription& described) {
  const client::AxisInfo& axis = described.axis;
  Json json{{"unit_kind", to_string(axis.unit.kind)},
            {"unit_size", axis.unit.size},
            {"modes", names_of_modes(axis.supported_drive_modes)},
            {"user_position_lower_limit", axis.user_position_lower_limit},
            {"user_position_upper_limit", axis.user_position_upper_limit},
            {"app_speed_limit", axis.app_speed_limit}};
  for (const std::string name :
       {"user_position_lower_limit", "user_position_upper_limit", "app_speed_limit"}) {
    json[name + "_in_unit"] = client::from_user_units(json[name].get<double>(), axis.unit);
  }
  for (const ObjectRow row : kModelObjects) {
    const auto value = value_in(described.readings, row);
    json[std::string(describe(row).variable_name)] = value ? Json(*value) : Json(nullptr);
  }
  return json;
}

std::string units_or_nothing(const ObjectDescription& object) {
  return object.units == "-" ? std::string() : english_units(object);
}

/// The texts of the record are the columns of object_lines().
Record differing_record(const client::ObjectReading& reading, const client::Unit& unit) {
  const ObjectRow row = *find_object(reading.object);
  const ObjectDescription& object = describe(row);
  const std::string name(object.variable_name);
  Record record{{"index", hex(object.address.index, 4), address_text(object.address)},
                {"subindex", object.address.subindex},
                {"name", name, name}};
  if (reading.code == AbortCode::none) {
    record.push_back({"value", reading.value, object_value_text(row, reading.value, unit)});
    add_in_unit(record, row, unit, "value", reading.value);
  } else {
    const std::string message(vdrive::describe(reading.code));
    record.push_back({"code", hex(wire_code(reading.code), 8)});
    record.push_back({"message", message, "refused: " + message});
  }
  record.push_back(
      {"default", object.default_value, object_value_text(row, object.default_value, unit)});
  add_in_unit(record, row, unit, "default", object.default_value);
  const std::string units = units_or_nothing(object);
  record.push_back({"units", units, units});
  return record;
}

std::string fault_line(const AxisDescription& described) {
  const auto code = last_fault_of(described.status, described.readings);
  if (!code) return "none";
  const bool is_present = described.status.status.error_code == *code;
  return error_text(*code) +
         (described.fault_tick ? " in tick " + std::to_string(*described.fault_tick)
                               : ", at a tick that is no longer known") +
         (is_present ? ", present" : ", reset");
}

std::string unit_line(const client::Unit& unit) {
  return std::string(to_string(unit.kind)) + ", " + escaped(unit.name) + "; " + to_text(unit.size) +
         " UU are one " +
         (unit.kind == client::UnitKind::rotary ? "revolution" : escaped(unit.name));
}

std::string words_or_none(const std::vector<std::string>& words) {
  return words.empty() ? "none" : joined(words);
}

/// @return the lines of the description about the model of the axis.
std::vector<std::string> model_lines(const AxisDescription& described) {
  const client::AxisInfo& axis = described.axis;
  const auto number = [&described](ObjectRow row) {
    return number_or_unknown(described.readings, row);
  };
  return {
      "  unit        " + unit_line(axis.unit),
      "  modes       " + words_or_none(names_of_modes(axis.supported_drive_modes)),
      "  at power-up position " +
          quantity_text(axis.user_position_lower_limit, Dimension::position, axis.unit) + " to " +
          quantity_text(axis.user_position_upper_limit, Dimension::position, axis.unit) +
          ", speed up to " + quantity_text(axis.app_speed_limit, Dimension::velocity, axis.unit),
      "  motor       type " + number(kMotorType) + ", rated " +
          number("motor_rated_torque"_object) + " mN.m and " +
          number("motor_rated_current"_object) + " mA, up to " +
          number("motor_max_speed_rpm"_object) + " RPM",
      "  gear        " + number("gear_ratio_numerator"_object) + " load to " +
          number("gear_ratio_denominator"_object) + " motor revolutions"};
}

/// The changed objects, in columns.
std::vector<std::string> object_lines(const std::vector<client::ObjectReading>& objects,
                                      const client::Unit& unit) {
  std::vector<std::vector<std::string>> rows{
      {"object", "variable_name", "value", "default", "units"}};
  for (const client::ObjectReading& object : objects) {
    rows.push_back(record_columns(differing_record(object, unit)));
  }
  return table_lines(rows, "    ");
}

}  // namespace

const std::vector<ObjectAddress>& described_objects() {
  static const std::vector<ObjectAddress> objects = [] {
    std::vector<ObjectAddress> addresses{describe(kNewestError).address,
                                         describe(kMotorType).address};
    for (const ObjectDescription& object : kObjectTable) {
      if (can_differ(object)) addresses.push_back(object.address);
    }
    return addresses;
  }();
  return objects;
}

std::optional<std::uint16_t> last_fault_of(const client::AxisSnapshot& status,
                                           const client::Readings& readings) {
  // The low word of 1003h is the code; the high word is manufacturer-specific.
  constexpr std::int64_t kCode = 0xFFFF;
  const auto newest =
      static_cast<std::uint16_t>(value_in(readings, kNewestError).value_or(0) & kCode);
  if (newest != 0) return newest;
  if (status.status.error_code != 0) return status.status.error_code;
  return std::nullopt;
}

Json description_json(const AxisDescription& described) {
  Json json = status_json(described.status, AxisLabel{described.axis.name, described.axis.unit});
  json["mode"] = to_string(described.status.mode());
  json["bench"] = described.bench.number;
  json["bench_name"] = described.bench.name;
  json["clock"] = to_string(described.bench.clock_mode);
  json["period_us"] = described.bench.period.count();
  json["fault"] = fault_json(described);
  json["model"] = model_json(described);
  json["objects_tick"] = described.readings.tick;
  Json objects = Json::array();
  for (const client::ObjectReading& object : differing(described.readings)) {
    objects.push_back(record_json(differing_record(object, described.axis.unit)));
  }
  json["objects"] = std::move(objects);
  return json;
}

std::vector<std::string> description_text(const AxisDescription& described) {
  std::vector<std::string> lines =
      status_text(described.status, {described.axis.name, described.axis.unit});
  const client::BenchInfo& bench = described.bench;
  lines.push_back("  bench       " + std::to_string(bench.number) + " " + escaped(bench.name) +
                  ", " + std::string(to_string(bench.clock_mode)) + ", " +
                  std::to_string(bench.period.count()) + " us a tick");
  lines.push_back("  last fault  " + fault_line(described));
  lines.push_back("  faults      " + std::to_string(described.status.status.fault_count) +
                  " since power-up");
  std::ranges::move(model_lines(described), std::back_inserter(lines));
  const auto objects = differing(described.readings);
  lines.push_back("  objects     " +
                  (objects.empty()
                       ? "all have their defaults"
                       : counted(objects.size(), "differs", "differ") + " from the default"));
  if (!objects.empty()) {
    std::ranges::move(object_lines(objects, described.axis.unit), std::back_inserter(lines));
  }
  return lines;
}

}  // namespace vdrive::tool
