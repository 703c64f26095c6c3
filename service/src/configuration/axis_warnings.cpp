// SPDX-License-Identifier: Apache-2.0
#include "configuration/axis_warnings.hpp"

#include "configuration/axis_units.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;
using settings::YamlValue;

/// @return the value of a key; nullptr if the file does not have it.
const YamlValue* entry_of(const AxisEntries& entries, const std::string& key) {
  const auto entry = entries.find(key);
  return entry == entries.end() ? nullptr : &entry->second;
}

/// @return the value that `parameters` gives an object, if any.
std::optional<YamlValue> parameter_entry(const AxisEntries& entries, ObjectRow row) {
  std::optional<YamlValue> found;
  const YamlValue* const parameters = entry_of(entries, "parameters");
  if (parameters == nullptr) return found;
  parameters->for_each_entry({}, [&](const std::string& key, const YamlValue& value) {
    if (parse_object(key) == describe(row).address) found.emplace(value);
  });
  return found;
}

void warn_at(const YamlValue& place, const NamedAxis& axis, const std::string& finding,
             std::vector<std::string>& warnings) {
  warnings.push_back(place.message("axis " + std::to_string(axis.number) + " " +
                                   escaped(axis.name) + ": " + finding));
}

void warn_of_limits_without_effect(const NamedAxis& axis, const AxisEntries& entries,
                                   std::vector<std::string>& warnings) {
  if (given_value(axis.configuration, "app_position_limit_switch"_object).value_or(0) != 0) return;
  for (const ObjectRow row :
       std::array{"user_position_lower_limit"_object, "user_position_upper_limit"_object}) {
    const auto limit = given_value(axis.configuration, row);
    if (!limit) continue;
    const auto place = parameter_entry(entries, row);
    if (!place) continue;
    warn_at(*place, axis,
            std::string(describe(row).variable_name) + " = " +
                object_value_text(row, *limit, axis.unit) +
                " has no effect because app_position_limit_switch (3535h) is 0; set it to 1",
            warnings);
  }
}

/// `mechanics` is written in lengths and angles, but a number without a unit is in user units
/// there, too: 300 is not 300 mm. 0 is the same in every unit.
void warn_of_limits_without_unit(const NamedAxis& axis, const AxisEntries& entries,
                                 std::vector<std::string>& warnings) {
  const YamlValue* const mechanics = entry_of(entries, "mechanics");
  if (mechanics == nullptr) return;
  const auto examine_limit = [&](const YamlValue& limit) {
    const std::int64_t number = parse_integer(limit.text()).value_or(0);
    if (number == 0) return;
    const std::string text = std::to_string(number);
    warn_at(limit, axis,
            text + " means " + text + " UU = " + position_text(number, axis.unit) + "; write " +
                text + axis.unit.name + ", or " + text + "UU",
            warnings);
  };
  mechanics->for_each_entry({}, [&](const std::string& key, const YamlValue& value) {
    if (key == "software_limit") value.for_each_element(examine_limit);
  });
}

/// 6064h has 4096 user units per revolution, whatever `unit` says. With a gear and a single encoder
/// a revolution of the load has a different number of them, and `unit` may mean either.
/// @return the problem with a unit of an angle; empty if there is none
std::string contradiction_of_angle(const NamedAxis& axis) {
  const double turn = user_units_per_load_turn(axis.configuration);
  const auto is = [&axis](double size) {
    return std::abs(axis.unit.size / size - 1.0) < kSameSize;
  };
  if (is(turn) || is(kUserUnitsPerRevolution)) return {};
  return "unit has per_revolution = " + to_text(axis.unit.size) +
         ", but a revolution of the load has " + six_digits(turn) +
         " user units, so all angles are displayed wrong; use mechanics: {rotary_table: " +
         axis.unit.name + "} instead of unit";
}

/// 4096 user units may be any length. But if a user unit is a micrometre, or another decimal
/// fraction of a metre, the unit was probably chosen without regard to the lead of the machine.
/// @return the likely mistake in a unit of a length; empty if there is none
std::string contradiction_of_length(const NamedAxis& axis) {
  const auto in_millimetre = user_units_in(axis.unit, "mm");
  if (!in_millimetre) return {};  // the length of its unit is unknown
  const double decimals = std::log10(axis.unit.size);
  if (std::abs(decimals - std::round(decimals)) >= kSameSize) return {};
  const double turn = user_units_per_load_turn(axis.configuration);
  return "unit has per_unit = " + to_text(axis.unit.size) + ", and a revolution of the load has " +
         six_digits(turn) + " user units, that is a lead of " + six_digits(turn / *in_millimetre) +
         " mm; if the lead of the machine differs, all lengths are displayed wrong: use mechanics: "
         "{screw: {pitch: " +
         six_digits(from_user_units(turn, axis.unit)) + axis.unit.name +
         "}} with its lead instead of unit";
}

void warn_of_unit(const NamedAxis& axis, const AxisEntries& entries,
                  std::vector<std::string>& warnings) {
  const YamlValue* const unit = entry_of(entries, "unit");
  // The unit that follows from mechanics is right, and a different `unit` has been refused as an
  // error.
  if (unit == nullptr || entries.contains("mechanics")) return;
  const bool is_angle = axis.unit.kind == UnitKind::rotary;
  const std::string finding =
      is_angle ? contradiction_of_angle(axis) : contradiction_of_length(axis);
  if (!finding.empty()) warn_at(*unit, axis, finding, warnings);
}

/// @return the highest velocity that 6080h permits [UU/s], in whole user units as in the drive, and
///         at most the upper limit of 607Fh.
std::int64_t motor_limit_of(const NamedAxis& axis) {
  const auto most = static_cast<double>(kObjectRows["app_speed_limit"_object].upper_limit);
  return static_cast<std::int64_t>(
      std::floor(std::min(highest_motor_velocity(axis.configuration), most)));
}

void warn_of_speed_limit(const NamedAxis& axis, const AxisEntries& entries,
                         std::vector<std::string>& warnings) {
  const auto limit = given_value(axis.configuration, "app_speed_limit"_object);
  const std::int64_t highest = motor_limit_of(axis);
  if (!limit || *limit <= highest) return;
  const auto place = parameter_entry(entries, "app_speed_limit"_object);
  if (!place) return;  // not in the file: it follows from the mechanics
  warn_at(*place, axis,
          "app_speed_limit = " + quantity_text(*limit, Dimension::velocity, axis.unit) +
              " is above " + quantity_text(highest, Dimension::velocity, axis.unit) +
              ", the speed at motor_max_speed_rpm (6080h) = " +
              std::to_string(value_at_start(axis.configuration, "motor_max_speed_rpm"_object)) +
              ": the lower limit applies",
          warnings);
}

/// According to the manual, 6081h keeps any value, and the motion is limited to 607Fh and 6080h.
void warn_of_profile_velocity(const NamedAxis& axis, const AxisEntries& entries,
                              std::vector<std::string>& warnings) {
  const auto velocity = given_value(axis.configuration, "profile_velocity"_object);
  const std::int64_t limit = value_at_start(axis.configuration, "app_speed_limit"_object);
  const std::int64_t motor_limit = motor_limit_of(axis);
  const bool motor_is_lower = motor_limit < limit;
  const std::int64_t highest = motor_is_lower ? motor_limit : limit;
  if (!velocity || *velocity <= highest) return;
  const auto place = parameter_entry(entries, "profile_velocity"_object);
  if (!place) return;  // not in the file: it follows from the mechanics
  const ObjectRow row = motor_is_lower ? "motor_max_speed_rpm"_object : "app_speed_limit"_object;
  warn_at(*place, axis,
          "profile_velocity = " + quantity_text(*velocity, Dimension::velocity, axis.unit) +
              " is above " + quantity_text(highest, Dimension::velocity, axis.unit) +
              ", the highest speed with " + object_text(describe(row).address) + " = " +
              object_value_text(row, value_at_start(axis.configuration, row), axis.unit) +
              ": the drive keeps the value and moves at the lower speed",
          warnings);
}

}  // namespace

std::vector<std::string> axis_warnings(const NamedAxis& axis, const AxisEntries& entries) {
  std::vector<std::string> warnings;
  warn_of_limits_without_effect(axis, entries, warnings);
  warn_of_limits_without_unit(axis, entries, warnings);
  warn_of_unit(axis, entries, warnings);
  warn_of_speed_limit(axis, entries, warnings);
  warn_of_profile_velocity(axis, entries, warnings);
  return warnings;
}

}  // namespace vdrive::service
