// SPDX-License-Identifier: Apache-2.0
#include "configuration/configuration_warnings.hpp"

#include "configuration/configuration_file.hpp"
#include "settings/yaml_reader.hpp"
#include "vdrive/plant/loop_report.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace vdrive::service {
namespace {

using settings::YamlValue;

/// An oscillation that lasts longer counts as ringing [s].
constexpr double kLongestRinging = 0.25;

/// Warn if a loop reaches less than this fraction of its configured bandwidth.
constexpr double kLeastBandwidth = 0.5;

/// @return the value with three significant digits, or as a whole number.
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

/// @return the problems; empty if there are none.
std::string findings_of(const LoopReport& report, const AxisModel& model) {
  std::string findings;
  if (std::isinf(report.ringing_time)) {
    add_warning(findings, "the axis is unstable: an oscillation at " +
                              three_digits(report.ringing) + " Hz grows");
  } else if (report.ringing_time > kLongestRinging) {
    add_warning(findings, "the axis rings at " + three_digits(report.ringing) + " Hz for " +
                              three_digits(report.ringing_time) + " s");
  }
  if (report.velocity_bandwidth < kLeastBandwidth * model.velocity_loop_bandwidth) {
    add_warning(findings, "the velocity loop reaches only " +
                              three_digits(report.velocity_bandwidth) + " of " +
                              three_digits(model.velocity_loop_bandwidth) +
                              " Hz, the position loop " + three_digits(report.position_bandwidth) +
                              " of " + three_digits(model.position_loop_bandwidth) + " Hz");
  }
  if (report.torque_needed > report.torque_limit) {
    add_warning(findings, "profile_acc and profile_dec need " + three_digits(report.torque_needed) +
                              " N.m at the motor, whose limit is " +
                              three_digits(report.torque_limit) + " N.m");
  }
  return findings;
}

/// @return the numbers that explain the findings.
std::string reasons_of(const LoopReport& report) {
  std::string reasons =
      "the total inertia is " + three_digits(report.inertia_ratio) + " times the motor inertia";
  if (report.load_resonance > 0.0) {
    reasons +=
        ", the load's resonance on its shaft is " + three_digits(report.load_resonance) + " Hz";
  }
  if (report.gear_ratio > 1.0) {
    reasons += ", the load turns " + three_digits(report.gear_ratio) +
               " times as fast as the motor (a reduction gear has gear_ratio_numerator below "
               "gear_ratio_denominator)";
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

}  // namespace

std::vector<std::string> start_warnings(const Configuration& configuration) {
  std::vector<std::string> warnings;
  for (const NamedAxis& axis : configuration.axes) {
    warnings.insert(warnings.end(), axis.warnings.begin(), axis.warnings.end());
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
