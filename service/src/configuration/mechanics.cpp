// SPDX-License-Identifier: Apache-2.0
#include "configuration/mechanics.hpp"

#include "configuration/axis_units.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/quantity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;
using settings::Any;
using settings::IntegerLimits;
using settings::key;
using settings::Row;
using settings::YamlValue;

constexpr std::int64_t kMostTeeth = 100'000;
constexpr std::int64_t kMostStarts = 64;

/// A length in the unit in which it was written.
struct Length {
  double value = 0.0;
  std::string unit;  ///< m, cm, mm or um
};

/// Turns of the motor to turns of the load.
struct GearTurns {
  std::uint32_t motor = 1;
  std::uint32_t load = 1;
};

/// The content of `mechanics`.
struct Mechanics {
  UnitKind kind = UnitKind::linear;
  std::string unit{};      ///< of the axis
  double travel = 0.0;     ///< linear: per turn of the load [unit]
  std::size_t drives = 0;  ///< how many of screw, belt, rack and rotary_table are given
  GearTurns gear{};
  std::optional<YamlValue> resolution{};
  std::optional<YamlValue> software_limit{};
};

/// For checking units of length: a metre converts to all of them.
const Unit kMetre{.kind = UnitKind::linear, .name = "m", .size = 1.0};

void read_value(const YamlValue& value, const Any& /*rule*/, Length& place) {
  const std::string problem = "must be a length above 0 with its unit, such as 5mm (m, cm, mm, um)";
  try {
    const WrittenQuantity length = read_quantity(value.text(), Dimension::position);
    const bool is_length = !length.is_in_user_units() && user_units_in(kMetre, length.unit);
    if (!is_length || length.value <= 0.0) value.refuse(problem);
    place = {length.value, length.unit};
  } catch (const std::invalid_argument&) {
    value.refuse(problem);
  }
}

void read_value(const YamlValue& value, const Any& /*rule*/, GearTurns& gear) {
  const std::string text = value.text();
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos) {
    const auto motor = parse_digits<std::uint32_t>(std::string_view(text).substr(0, colon));
    const auto load = parse_digits<std::uint32_t>(std::string_view(text).substr(colon + 1));
    if (motor.value_or(0) != 0 && load.value_or(0) != 0) {
      gear = {*motor, *load};
      return;
    }
  }
  value.refuse(
      "must be turns of the motor to turns of the load, two whole numbers from 1 to 4294967295, "
      "such as 10:1 for a reduction of ten to one, or 25:2");
}

void take_length(Mechanics& mechanics, double travel, const std::string& unit) {
  ++mechanics.drives;
  mechanics.kind = UnitKind::linear;
  mechanics.unit = unit;
  mechanics.travel = travel;
}

struct Screw {
  Length pitch;
  std::int64_t starts = 1;
};

constexpr auto kScrewRows = std::to_array<Row<Screw>>({
    key<&Screw::pitch>("pitch", Any{}, {},
                       {.needed = "a screw needs its pitch, such as {pitch: 5mm}"}),
    key<&Screw::starts>("starts", IntegerLimits{1, kMostStarts, ""}),
});

/// A turn of a screw moves the load by its pitch times its starts.
void take_screw(const YamlValue& value, Mechanics& mechanics) {
  Screw screw;
  read_section(value, kScrewRows, screw);
  take_length(mechanics, screw.pitch.value * static_cast<double>(screw.starts), screw.pitch.unit);
}

struct Wheel {
  std::optional<Length> diameter;
  std::optional<std::int64_t> teeth;
  std::optional<Length> pitch;
};

constexpr auto kWheelRows = std::to_array<Row<Wheel>>({
    key<&Wheel::diameter>("diameter"),
    key<&Wheel::teeth>("teeth", IntegerLimits{1, kMostTeeth, ""}),
    key<&Wheel::pitch>("pitch"),
});

/// A turn of a pulley or a pinion moves the load by its circumference.
void take_wheel(const YamlValue& value, Mechanics& mechanics) {
  Wheel wheel;
  read_section(value, kWheelRows, wheel);
  const auto& [diameter, teeth, pitch] = wheel;
  const bool has_teeth = teeth && pitch;
  if (diameter.has_value() == has_teeth || teeth.has_value() != pitch.has_value()) {
    value.refuse(
        "needs either the diameter, such as {diameter: 40mm}, or teeth and their pitch, "
        "such as {teeth: 20, pitch: 5mm}");
  }
  if (diameter) {
    take_length(mechanics, diameter->value * std::numbers::pi, diameter->unit);
  } else {
    take_length(mechanics, pitch->value * static_cast<double>(*teeth), pitch->unit);
  }
}

void take_angle(const YamlValue& value, Mechanics& mechanics) {
  ++mechanics.drives;
  mechanics.kind = UnitKind::rotary;
  mechanics.unit = value.text();
  if (const auto problem = check_unit_name(UnitKind::rotary, mechanics.unit)) {
    value.refuse(*problem);
  }
}

constexpr auto kMechanicsRows = std::to_array<Row<Mechanics>>({
    {.key = "screw",
     .what = "{pitch: LENGTH, starts: N}: the load moves by the pitch, times the starts (1 to 64, "
             "default 1), per turn of the screw. A length has its unit, such as 5mm; the unit of "
             "the axis follows from it.",
     .then = take_screw},
    {.key = "belt",
     .what = "{diameter: LENGTH} or {teeth: N, pitch: LENGTH} of the pulley: the load moves by its "
             "circumference per turn.",
     .then = take_wheel},
    {.key = "rack",
     .what = "As for belt, but of the pinion that moves the rack.",
     .then = take_wheel},
    {.key = "rotary_table", .what = "The unit of the angle: deg, rad or rev.", .then = take_angle},
    key<&Mechanics::gear>("gear", Any{},
                          "Turns of the motor to turns of the screw, pulley, pinion or table, such "
                          "as 10:1, which sets 3576h and 3577h. Default: 1:1."),
    key<&Mechanics::resolution>(
        "resolution", Any{},
        "Required step, such as 5um; an error if a user unit is larger. Default: none."),
    key<&Mechanics::software_limit>(
        "software_limit", Any{},
        "[LOWER, UPPER] such as [-10mm, 300mm]: sets 607Dh and 3535h. Default: none."),
});

void set(AxisConfiguration& axis, ObjectRow row, std::int64_t value) {
  axis.parameters.push_back({describe(row).address, value});
}

/// @return the size of a user unit, such as "1.2207 um"; a small length in a smaller unit.
std::string step_text(const Unit& unit) {
  constexpr double kSmallStep = 0.01;
  const double step = from_user_units(1.0, unit);
  const auto in_micrometres = user_units_in(unit, "um");
  if (step < kSmallStep && in_micrometres) return six_digits(1.0 / *in_micrometres) + " um";
  return six_digits(step) + " " + unit.name;
}

void check_resolution(const YamlValue& value, const NamedAxis& axis) {
  const std::string problem =
      "must be a length or an angle above 0 with its unit, such as 5um or 0.1deg";
  std::optional<double> wanted;
  try {
    const WrittenQuantity written = read_quantity(value.text(), Dimension::position);
    if (!written.is_in_user_units()) wanted = to_user_units(written, axis.unit);
  } catch (const std::invalid_argument&) {
    value.refuse(problem);
  }
  if (!wanted || *wanted <= 0.0) {
    value.refuse(problem + "; the axis has " + list_of_units(Dimension::position, axis.unit));
  }
  if (*wanted >= 1.0 - kSameSize) return;
  value.refuse("is finer than one user unit (" + step_text(axis.unit) +
               "): a turn of the load has " +
               six_digits(user_units_per_load_turn(axis.configuration)) + " user units");
}

void read_software_limits(const YamlValue& value, NamedAxis& axis) {
  constexpr IntegerLimits kLimits{std::numeric_limits<std::int32_t>::min(),
                                  std::numeric_limits<std::int32_t>::max(), "UU"};
  std::vector<std::int64_t> limits;
  value.for_each_element([&](const YamlValue& element) {
    limits.push_back(read_user_units(element, Dimension::position, axis.unit, kLimits));
  });
  if (limits.size() != 2) {
    value.refuse("must be a list of the lower and the upper limit, such as [-10mm, 300mm]");
  }
  if (limits[0] >= limits[1]) {
    value.refuse("the lower limit, " + quantity_text(limits[0], Dimension::position, axis.unit) +
                 ", must be below the upper one, " +
                 quantity_text(limits[1], Dimension::position, axis.unit));
  }
  set(axis.configuration, "user_position_lower_limit"_object, limits[0]);
  set(axis.configuration, "user_position_upper_limit"_object, limits[1]);
  set(axis.configuration, "app_position_limit_switch"_object, 1);
}

/// Objects whose default is a speed or a ramp.
constexpr std::array kSpeedsAndRamps{"profile_velocity"_object,    "profile_acc"_object,
                                     "profile_dec"_object,         "quick_stop_deceleration"_object,
                                     "homing_speed_search"_object, "homing_speed_creep"_object,
                                     "homing_acceleration"_object};

// ---- the table ----------------------------------------------------------------------------------

constexpr std::array<std::string_view, 6> kColumns{
    "axes", "a turn of the load", "a user unit", "highest speed", "gear", "software limits"};

using Line = std::array<std::string, kColumns.size()>;

std::string gear_text(const AxisConfiguration& axis) {
  return std::to_string(value_at_start(axis, "gear_ratio_denominator"_object)) + ":" +
         std::to_string(value_at_start(axis, "gear_ratio_numerator"_object));
}

std::string limits_text(const NamedAxis& axis) {
  const AxisConfiguration& configuration = axis.configuration;
  const auto lower = given_value(configuration, "user_position_lower_limit"_object);
  const auto upper = given_value(configuration, "user_position_upper_limit"_object);
  const bool is_on = value_at_start(configuration, "app_position_limit_switch"_object) != 0;
  if (!is_on || (!lower && !upper)) return "none";
  const auto text = [&axis](std::optional<std::int64_t> limit) {
    return limit ? position_text(*limit, axis.unit) : std::string("none");
  };
  return text(lower) + " to " + text(upper);
}

/// @return the values of an axis, without its number.
Line line_of(const NamedAxis& axis) {
  const AxisConfiguration& configuration = axis.configuration;
  const double highest =
      std::min(static_cast<double>(value_at_start(configuration, "app_speed_limit"_object)),
               highest_motor_velocity(configuration));
  const auto in_unit = [&axis](double user_units) {
    return six_digits(from_user_units(user_units, axis.unit)) + " " + axis.unit.name;
  };
  return {"",
          in_unit(user_units_per_load_turn(configuration)),
          step_text(axis.unit),
          in_unit(highest) + "/s",
          gear_text(configuration),
          limits_text(axis)};
}

/// Adds an axis to a list of numbers such as "1-3, 5": extends its last range or begins a new one.
void add_number(std::string& numbers, std::uint16_t last, std::uint16_t number) {
  const std::string text = std::to_string(number);
  if (numbers.empty()) {
    numbers = text;
  } else if (number != last + 1) {
    numbers += ", " + text;
  } else {
    const std::size_t dash = numbers.find_last_of("-,");
    const bool continues = dash != std::string::npos && numbers[dash] == '-';
    numbers = (continues ? numbers.substr(0, dash) : numbers) + "-" + text;
  }
}

}  // namespace

void read_mechanics(const YamlValue& value, NamedAxis& axis) {
  Mechanics mechanics;
  read_section(value, kMechanicsRows, mechanics);
  if (mechanics.drives != 1) {
    value.refuse(
        "must have exactly one of screw, belt, rack and rotary_table, such as {screw: "
        "{pitch: 5mm}, gear: 10:1}");
  }
  set(axis.configuration, "gear_ratio_numerator"_object, mechanics.gear.load);
  set(axis.configuration, "gear_ratio_denominator"_object, mechanics.gear.motor);
  const double turn = user_units_per_load_turn(axis.configuration);
  const bool is_linear = mechanics.kind == UnitKind::linear;
  axis.unit = {.kind = mechanics.kind,
               .name = mechanics.unit,
               .size = is_linear ? turn / mechanics.travel : turn};
  if (!is_usable(axis.unit)) {
    value.refuse("a " + axis.unit.name + " would have " + six_digits(axis.unit.size) +
                 " user units: must be from " + to_text(kSmallestUnit) + " to " +
                 to_text(kLargestUnit));
  }
  if (mechanics.resolution) check_resolution(*mechanics.resolution, axis);
  if (mechanics.software_limit) read_software_limits(*mechanics.software_limit, axis);
}

void complete_speeds(AxisConfiguration& axis) {
  const auto highest_value = static_cast<double>(std::numeric_limits<std::uint32_t>::max());
  const auto whole = [highest_value](double value) {
    return static_cast<std::int64_t>(std::clamp(std::floor(value), 1.0, highest_value));
  };
  const double highest = highest_motor_velocity(axis);
  const double scale = position_ratio(axis.model.feedback, gear_ratio_of(axis));
  const auto complete = [&axis, &whole](ObjectRow row, double value) {
    if (whole(value) != value_at_start(axis, row)) set(axis, row, whole(value));
  };
  if (!given_value(axis, "app_speed_limit"_object)) complete("app_speed_limit"_object, highest);
  for (const ObjectRow row : kSpeedsAndRamps) {
    if (given_value(axis, row)) continue;
    const double value = static_cast<double>(describe(row).default_value) * scale;
    complete(row, row == "profile_velocity"_object ? std::min(value, highest) : value);
  }
}

void describe_mechanics(const std::string& path, std::vector<settings::ConfigurationKey>& keys) {
  describe_section(path + ".", kMechanicsRows, keys);
}

std::vector<std::string> mechanics_table(const Configuration& configuration) {
  std::vector<std::pair<Line, std::uint16_t>> lines;  // each with its last axis
  for (const NamedAxis& axis : configuration.axes) {
    const Line facts = line_of(axis);
    auto same = std::ranges::find_if(lines, [&facts](const auto& line) {
      return std::equal(facts.begin() + 1, facts.end(), line.first.begin() + 1);
    });
    if (same == lines.end()) same = lines.insert(lines.end(), {facts, axis.number});
    add_number(same->first.front(), same->second, axis.number);
    same->second = axis.number;
  }
  std::array<std::size_t, kColumns.size()> widths{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    widths.at(i) = kColumns.at(i).size();
    for (const auto& [line, last] : lines) {
      widths.at(i) = std::max(widths.at(i), line.at(i).size());
    }
  }
  const auto text_of_line = [&widths](const auto& cells) {
    std::string text;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      text += std::string(cells.at(i));
      if (i + 1 < cells.size()) text.append(widths.at(i) + 2 - cells.at(i).size(), ' ');
    }
    return text;
  };
  std::vector<std::string> table{text_of_line(kColumns)};
  for (const auto& [line, last] : lines) table.push_back(text_of_line(line));
  return table;
}

}  // namespace vdrive::service
