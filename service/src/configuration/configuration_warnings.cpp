// SPDX-License-Identifier: Apache-2.0
#include "configuration/configuration_warnings.hpp"

#include "configuration/axis_units.hpp"
#include "configuration/configuration_file.hpp"
#include "settings/yaml_reader.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/plant/loop_report.hpp"
#include "vdrive/text.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;
using settings::YamlValue;

/// An oscillation that lasts longer is seen as ringing [s].
constexpr double kLongestRinging = 0.25;

/// Loops that are slower than this part of what is configured do not do what their author expects.
constexpr double kLeastBandwidth = 0.5;

/// @return three digits that count, or a whole number.
std::string three_digits(double value) {
  constexpr double kLeastWhole = 1'000.0;
  std::ostringstream text;
  if (value >= kLeastWhole) {
    text << std::fixed << std::setprecision(0) << value;
  } else {
    text << std::setprecision(3) << value;
  }
  return text.str();
}

void add_warning(std::string& findings, const std::string& finding) {
  findings += (findings.empty() ? "" : "; ") + finding;
}

/// @return what is wrong; empty = nothing.
std::string findings_of(const LoopReport& report, const AxisModel& model) {
  std::string findings;
  if (std::isinf(report.ringing_time)) {
    add_warning(findings,
                "the axis oscillates at " + three_digits(report.ringing) + " Hz, growing");
  } else if (report.ringing_time > kLongestRinging) {
    add_warning(findings, "the axis rings at " + three_digits(report.ringing) + " Hz for " +
                              three_digits(report.ringing_time) + " s");
  }
  if (report.velocity_bandwidth < kLeastBandwidth * model.velocity_loop_bandwidth) {
    add_warning(findings, "the velocity loop reaches " + three_digits(report.velocity_bandwidth) +
                              " Hz of " + three_digits(model.velocity_loop_bandwidth) +
                              " Hz, the position loop " + three_digits(report.position_bandwidth) +
                              " Hz of " + three_digits(model.position_loop_bandwidth) + " Hz");
  }
  if (report.torque_needed > report.torque_limit) {
    add_warning(findings, "profile_acc and profile_dec need " + three_digits(report.torque_needed) +
                              " N.m at the motor, its limit is " +
                              three_digits(report.torque_limit) + " N.m");
  }
  return findings;
}

/// @return the numbers behind the findings.
std::string reasons_of(const LoopReport& report) {
  std::string reasons = "motor and load have " + three_digits(report.inertia_ratio) +
                        " times the inertia of the motor";
  if (report.load_resonance > 0.0) {
    reasons +=
        ", the load's resonance on its shaft is " + three_digits(report.load_resonance) + " Hz";
  }
  if (report.gear_ratio > 1.0) {
    reasons += ", the load turns " + three_digits(report.gear_ratio) +
               " times as fast as the motor (a gear that reduces has a gear_ratio_numerator below "
               "its gear_ratio_denominator)";
  }
  return reasons;
}

void examine(const NamedAxis& axis, const Configuration& configuration, const YamlValue& place,
             std::vector<std::string>& warnings) {
  const AxisModel& model = axis.configuration.model;
  const LoopReport report = examine_loops(axis.configuration, configuration.period);
  const std::string findings = findings_of(report, model);
  if (findings.empty()) return;
  warnings.push_back(place.message("axis " + std::to_string(axis.number) + " (" + axis.name +
                                   "): " + findings + "; " + reasons_of(report)));
}

std::string name_of(const NamedAxis& axis) {
  return "axis " + std::to_string(axis.number) + " " + escaped(axis.name);
}

void warn_of_limits_without_effect(const NamedAxis& axis, std::vector<std::string>& warnings) {
  if (given_value(axis.configuration, "app_position_limit_switch"_object).value_or(0) != 0) return;
  for (const ObjectRow row :
       std::array{"user_position_lower_limit"_object, "user_position_upper_limit"_object}) {
    const auto limit = given_value(axis.configuration, row);
    if (!limit) continue;
    warnings.push_back(name_of(axis) + ": " + std::string(describe(row).variable_name) + " = " +
                       std::to_string(*limit) +
                       " has no effect: app_position_limit_switch (3535h) is 0");
  }
}

/// 6064h has 4096 user units a revolution, whatever `unit` says. With a gear and one encoder a
/// revolution of the load has others, and either may be meant.
void warn_of_unit(const NamedAxis& axis, std::vector<std::string>& warnings) {
  if (axis.unit.kind != UnitKind::rotary) return;
  const double turn = user_units_a_load_turn(axis.configuration);
  const auto is = [&axis](double size) {
    return std::abs(axis.unit.size / size - 1.0) < kSameSize;
  };
  if (is(turn) || is(kUserUnitsPerRevolution)) return;
  warnings.push_back(name_of(axis) + ": unit says per_revolution = " + to_text(axis.unit.size) +
                     ", but a revolution of the load has " + three_digits(turn) +
                     " user units: every angle is shown wrong; write mechanics: {rotary_table: " +
                     axis.unit.name + "} instead of unit");
}

void warn_of_speed_limit(const NamedAxis& axis, std::vector<std::string>& warnings) {
  const auto limit = given_value(axis.configuration, "app_speed_limit"_object);
  const double highest = std::floor(highest_motor_velocity(axis.configuration));
  if (!limit || static_cast<double>(*limit) <= highest) return;
  warnings.push_back(
      name_of(axis) + ": app_speed_limit = " + std::to_string(*limit) + " is above the " +
      to_text(highest) + " UU/s at which the motor turns at motor_max_speed_rpm (6080h) = " +
      std::to_string(value_at_start(axis.configuration, "motor_max_speed_rpm"_object)) +
      ": the lower one holds");
}

}  // namespace

std::vector<std::string> start_warnings(const Configuration& configuration) {
  std::vector<std::string> warnings;
  for (const NamedAxis& axis : configuration.axes) {
    warn_of_limits_without_effect(axis, warnings);
    warn_of_unit(axis, warnings);
    warn_of_speed_limit(axis, warnings);
  }
  return warnings;
}

std::vector<std::string> loop_warnings(const std::filesystem::path& file) {
  const Configuration configuration = load_configuration(file);
  std::vector<std::string> warnings;
  const YAML::Node document = settings::read_yaml(settings::read_yaml_file(file), file.string());
  if (!document.IsMap() || !document["axes"]) return warnings;
  YamlValue(document["axes"], file.string(), "axes").for_each_element([&](const YamlValue& place) {
    place.for_each_entry({}, [&](const std::string& key, const YamlValue& entry) {
      if (key != "number") return;
      const auto number = static_cast<std::uint16_t>(entry.integer({1, kAxisNumbers - 1, ""}));
      const auto axis = std::ranges::find(configuration.axes, number, &NamedAxis::number);
      if (axis != configuration.axes.end()) examine(*axis, configuration, place, warnings);
    });
  });
  return warnings;
}

}  // namespace vdrive::service
