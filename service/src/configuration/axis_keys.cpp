// SPDX-License-Identifier: Apache-2.0
// The keys of an axis: `axes[]` of a configuration.
#include "configuration/axis_units.hpp"
#include "configuration/configuration_keys.hpp"
#include "configuration/mechanics.hpp"
#include "settings/unit_settings.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"
#include "vdrive/dictionary/object_text.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/plant/model_parameters.hpp"
#include "vdrive/wording.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace vdrive::service {
namespace {

using namespace vdrive::literals;
using settings::Any;
using settings::ConfigurationKey;
using settings::IntegerLimits;
using settings::key;
using settings::kOneOf;
using settings::NumberLimits;
using settings::Row;
using settings::Rule;
using settings::section;

constexpr std::int64_t kHighestAxisNumber = kAxisNumbers - 1;
constexpr std::int64_t kLongestDwell = 65'535;
constexpr IntegerLimits kPositions{std::numeric_limits<std::int32_t>::min(),
                                   std::numeric_limits<std::int32_t>::max(), "user units"};

// ---- settings ----------------------------------------------------------------------------------

constexpr auto kSettingsRows = std::to_array<Row<AxisSettings>>({
    key<&AxisSettings::acknowledge_while_halted>(
        "acknowledge_while_halted", Any{},
        "false: set-points are not accepted while bit 8 (halt) of the controlword is 1."),
    key<&AxisSettings::enable_from_switch_on_disabled>(
        "enable_from_switch_on_disabled", Any{},
        "true: the controlword 000Fh in Switch on disabled enables."),
    key<&AxisSettings::following_error_is_fault>(
        "following_error_is_fault", Any{},
        "false: a following error shows in bit 13 of the statusword only."),
    key<&AxisSettings::limits_need_homing>("limits_need_homing", Any{},
                                           "true: 607Dh applies only once the axis is homed."),
    key<&AxisSettings::quick_stop_dwell_ms>("quick_stop_dwell_ms",
                                            IntegerLimits{0, kLongestDwell, "ms"},
                                            "Minimum time in Quick stop active, {} ms."),
});

// ---- model -------------------------------------------------------------------------------------

template <std::size_t kPlace>
void describe_parameter(const std::string& path, std::vector<ConfigurationKey>& keys) {
  constexpr const ModelParameter& kParameter = kModelParameters[kPlace];
  keys.push_back({path, std::string(kParameter.what) + ", " + to_text(kParameter.lowest) +
                            (kParameter.from_zero_if_rigid ? " (rigid: 0)" : "") + " to " +
                            with_unit(kParameter.highest, kParameter) + "."});
}

/// The row has no limits, because they depend on the coupling, which may come later in the file;
/// check_model() checks them.
template <std::size_t kPlace>
constexpr Row<AxisModel> parameter_row() {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  constexpr const ModelParameter& kParameter = kModelParameters[kPlace];
  return key<kParameter.member>(kParameter.name, NumberLimits{-kAny, kAny, kParameter.unit}, {},
                                {.describe = describe_parameter<kPlace>});
}

template <std::size_t... kPlaces>
constexpr auto model_rows(std::index_sequence<kPlaces...> /*parameters*/) {
  return std::to_array<Row<AxisModel>>(
      {key<&AxisModel::coupling>(
           "coupling", kOneOf<Coupling::rigid, Coupling::two_inertia>,
           "rigid: one inertia; two_inertia: motor and load on an elastic shaft."),
       key<&AxisModel::feedback>(
           "feedback", kOneOf<Feedback::single_encoder, Feedback::dual_encoder>,
           "The position loop uses the encoder of the motor (single_encoder) or of the load "
           "(dual_encoder)."),
       parameter_row<kPlaces>()...});
}

constexpr auto kModelRows = model_rows(std::make_index_sequence<kModelParameters.size()>());

void check_model(const YamlValue& value, NamedAxis& axis) {
  value.for_each_entry({}, [&](const std::string& key, const YamlValue& entry) {
    const auto* const parameter = std::ranges::find(kModelParameters, key, &ModelParameter::name);
    if (parameter == kModelParameters.end()) return;
    const auto limits = limits_broken(axis.configuration.model, *parameter);
    if (limits) entry.refuse(*limits);
  });
}

// ---- parameters --------------------------------------------------------------------------------

/// @return the row that `key` names by variable_name, name in the standard or address.
ObjectRow row_named(const std::string& key, const YamlValue& value) {
  const auto object = parse_object(key);
  const auto row = object ? find_object(*object) : std::nullopt;
  if (row) return *row;
  const std::string advice = object ? advice_on(*object, check_address(*object)) : "";
  if (!advice.empty()) value.refuse("no such object: " + advice);
  const std::string address = address_suggestion(key);
  value.refuse("no such object" +
               (address.empty() ? suggestion(key, names_of_objects()) : address) +
               R"(; write its variable_name, "0x6081" or "0x607D:1")");
}

/// Applies the rules of the drive for a write: refuses the same values, with their line. Values
/// that are only accepted on a modulo axis are accepted here; `check_direction` checks them.
std::int64_t read_object_value(const YamlValue& value, ObjectRow row) {
  const ObjectDescription& object = describe(row);
  if (is_identity(object.address)) {
    return value.integer({object.lower_limit, object.upper_limit, ""});
  }
  const auto number = parse_integer(value.text());
  const AbortCode code = number ? check_value_on_modulo_axis(row, *number) : AbortCode::none;
  if (number && code == AbortCode::none) return *number;
  if (code == AbortCode::write_of_read_only_object) value.refuse(std::string(describe(code)));
  if (number && !few_values(row).empty()) value.refuse("must be " + values_text(row));
  const std::string units = object.units == "-" ? std::string() : english_units(object);
  const std::int64_t in_range = value.integer({object.lower_limit, object.upper_limit, units});
  if (code != AbortCode::none) value.refuse(std::string(describe(code)));
  return in_range;
}

/// A value of `parameters` and its place in the file.
struct PlacedValue {
  std::int64_t value;
  YamlValue place;
};

/// Refuses limits in the wrong order: the drive would accept them, but then have no limits.
void check_software_limits(const std::map<ObjectAddress, PlacedValue>& values, const Unit& unit) {
  const auto lower = values.find(kObjectRows["user_position_lower_limit"_object].address);
  const auto upper = values.find(kObjectRows["user_position_upper_limit"_object].address);
  if (lower == values.end() || upper == values.end()) return;
  if (lower->second.value < upper->second.value) return;
  lower->second.place.refuse("must be below user_position_upper_limit (607Dh:2) = " +
                             quantity_text(upper->second.value, Dimension::position, unit));
}

/// Refuses bits 6 and 7 of 60F2h without a position range (607Bh), as the drive does.
void check_direction(const std::map<ObjectAddress, PlacedValue>& values) {
  const ObjectRow option = "positioning_option_code"_object;
  const auto value = values.find(describe(option).address);
  if (value == values.end()) return;
  if (check_object_value(option, value->second.value) == AbortCode::none) return;
  const auto lower = values.find(kObjectRows["min_position_range_limit"_object].address);
  const auto upper = values.find(kObjectRows["max_position_range_limit"_object].address);
  const std::int64_t first = lower == values.end() ? 0 : lower->second.value;
  const std::int64_t last = upper == values.end() ? 0 : upper->second.value;
  if (first < last) return;
  value->second.place.refuse(
      "must be " + values_text(option) +
      ", because bits 6 and 7 need a modulo axis: set min_position_range_limit (607Bh:1) below "
      "max_position_range_limit (607Bh:2)");
}

/// Moves the range (607Bh) to the front: it makes the axis a modulo axis, and only that accepts
/// bits 6 and 7 of 60F2h.
void put_range_first(std::vector<InitialValue>& parameters) {
  constexpr std::uint16_t kRange = kObjectRows["min_position_range_limit"_object].address.index;
  const auto is_of_range = [](const InitialValue& parameter) {
    return parameter.address.index == kRange;
  };
  std::vector<InitialValue> ordered;
  ordered.reserve(parameters.size());
  std::ranges::copy_if(parameters, std::back_inserter(ordered), is_of_range);
  std::ranges::remove_copy_if(parameters, std::back_inserter(ordered), is_of_range);
  parameters = std::move(ordered);
}

/// @return what writing an object does besides setting its value; empty if nothing.
std::string_view effect_of(const ObjectDescription& object) {
  if (object.role == Role::command) return "commands the axis";
  if (object.change == Change::memory) return "stores or restores parameters";
  return object.change == Change::history ? "clears the error history" : "";
}

/// Refuses objects that act when they are written: they have no value to set at power-up.
void check_is_parameter(const ObjectDescription& object, const YamlValue& value) {
  const std::string_view effect = effect_of(object);
  if (effect.empty()) return;
  value.refuse(std::string(object.variable_name) + " (" + address_text(object.address) +
               ") is not a parameter, because writing it " + std::string(effect) +
               "; parameters are objects that keep a value, such as profile_velocity, and test "
               "inputs, such as test_load_torque");
}

/// Positions, speeds, ramps and jerks may have a unit of the axis.
/// @return a value that the object accepts [units of the object]
std::int64_t read_parameter(const YamlValue& value, ObjectRow row, const Unit& unit) {
  const auto dimension = dimension_of(row);
  if (!dimension) return read_object_value(value, row);
  const ObjectDescription& object = describe(row);
  if (object.access == Access::read_only) {
    value.refuse(std::string(describe(AbortCode::write_of_read_only_object)));
  }
  return read_user_units(value, *dimension, unit, {object.lower_limit, object.upper_limit, ""});
}

/// Refuses a value that differs from the one that follows from `mechanics`.
void check_against_mechanics(ObjectRow row, std::int64_t value, const YamlValue& place,
                             const Unit& unit, std::span<const InitialValue> decided) {
  const ObjectDescription& object = describe(row);
  const auto other = std::ranges::find(decided, object.address, &InitialValue::address);
  if (other == decided.end() || other->value == value) return;
  place.refuse("contradicts mechanics, from which " + std::string(object.variable_name) + " = " +
               object_value_text(row, other->value, unit) + " follows");
}

/// @param axis already has its unit and the values that follow from `mechanics`
void read_parameters(const YamlValue& value, NamedAxis& axis) {
  std::vector<InitialValue>& parameters = axis.configuration.parameters;
  const std::vector<InitialValue> decided = parameters;
  std::map<ObjectAddress, PlacedValue> values;
  value.for_each_entry({}, [&](const auto& key, const YamlValue& entry) {
    const ObjectRow row = row_named(key, entry);
    const ObjectDescription& object = describe(row);
    check_is_parameter(object, entry);
    const std::int64_t number = read_parameter(entry, row, axis.unit);
    const auto [first, is_first] = values.emplace(object.address, PlacedValue{number, entry});
    if (!is_first) {
      entry.refuse("the same object, " + address_text(object.address) + ", has the value " +
                   object_value_text(row, first->second.value, axis.unit) + " in line " +
                   std::to_string(first->second.place.line()));
    }
    check_against_mechanics(row, number, entry, axis.unit, decided);
    parameters.push_back({object.address, number});
  });
  check_software_limits(values, axis.unit);
  check_direction(values);
  put_range_first(parameters);
}

/// @return for example "profile_velocity [VelUU]".
std::string comment_on(ObjectRow row) {
  const ObjectDescription& object = describe(row);
  std::string comment(object.variable_name);
  if (object.units != "-") comment += " [" + english_units(object) + "]";
  return comment;
}

void write_parameters(YAML::Emitter& out, const Rule& /*rule*/, const NamedAxis& axis) {
  out << YAML::BeginMap;
  for (const auto& parameter : axis.configuration.parameters) {
    out << YAML::Key << YAML::DoubleQuoted << address_text(parameter.address) << YAML::Value
        << parameter.value;
    if (const auto row = find_object(parameter.address)) out << YAML::Comment(comment_on(*row));
  }
  out << YAML::EndMap;
}

// ---- axis --------------------------------------------------------------------------------------

void check_axis_name(const YamlValue& value, NamedAxis& axis) {
  check_name(value, axis.name);
  if (axis.name.find(' ') != std::string::npos ||
      (axis.name.front() >= '0' && axis.name.front() <= '9')) {
    value.refuse("a name must not contain spaces or begin with a digit");
  }
}

void read_initial_position(const YamlValue& value, NamedAxis& axis) {
  axis.configuration.initial_position =
      static_cast<std::int32_t>(read_user_units(value, Dimension::position, axis.unit, kPositions));
}

void write_initial_position(YAML::Emitter& out, const Rule& /*rule*/, const NamedAxis& axis) {
  out << axis.configuration.initial_position;
}

bool has_parameters(const NamedAxis& axis) {
  return !axis.configuration.parameters.empty();
}

constexpr auto kAxisRows = std::to_array<Row<NamedAxis>>({
    key<&NamedAxis::number>("number", IntegerLimits{1, kHighestAxisNumber, ""},
                            "{}, unique on the bench. Required."),
    key<&NamedAxis::name>("name", Any{},
                          "Unique, no spaces, no digit first. Default: axis and its number.",
                          {.then = check_axis_name}),
    key<&NamedAxis::unit>("unit", Any{}, {}, {.describe = settings::describe_unit}),
    // `mechanics` is not printed; the keys that follow from it are.
    {.key = "mechanics", .then = read_mechanics, .describe = describe_mechanics},
    {.key = "initial_position",
     .what =
         "Position at the first power-up, {} user units, or with a unit of the axis, such as 25mm.",
     .rule = kPositions,
     .then = read_initial_position,
     .write = write_initial_position},
    section<kSettingsRows, &NamedAxis::configuration, &AxisConfiguration::settings>("settings"),
    section<kModelRows, &NamedAxis::configuration, &AxisConfiguration::model>(
        "model", {.then = check_model}),
    {.key = "parameters",
     .what = "Values of objects from power-up on, by variable_name, name in CiA 402 or address, "
             "such as profile_velocity: 68267 and \"0x607D:1\": -100000. Positions, speeds and "
             "ramps may have a unit of the axis: 250mm/s. The gear is load turns over motor turns: "
             "gear_ratio_numerator: 1 with gear_ratio_denominator: 10 is a reduction of 10:1.",
     .then = read_parameters,
     .write = write_parameters,
     .is_printed = has_parameters},
});

}  // namespace

std::span<const Row<NamedAxis>> axis_rows() noexcept {
  return kAxisRows;
}

}  // namespace vdrive::service
