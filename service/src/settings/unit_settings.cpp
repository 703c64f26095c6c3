// SPDX-License-Identifier: Apache-2.0
#include "settings/unit_settings.hpp"

#include "vdrive/number_text.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::settings {
namespace {

/// @return the key for the size of a unit of this kind.
std::string_view size_key(UnitKind kind) {
  return kind == UnitKind::rotary ? "per_revolution" : "per_unit";
}

/// The entries of a `unit` in the configuration, with their places.
struct UnitEntries {
  UnitKind kind{};
  std::optional<YamlValue> name{};
  std::optional<YamlValue> per_revolution{};
  std::optional<YamlValue> per_unit{};
};

constexpr auto kUnitRows = std::to_array<Row<UnitEntries>>({
    key<&UnitEntries::kind>(
        "kind", kOneOf<UnitKind::rotary, UnitKind::linear>,
        "Kind of the user units of the axis: rotary (fractions of a revolution) or linear "
        "(fractions of a length). Programs convert; the drive does not use it.",
        {.needed = "a unit needs a kind: rotary or linear"}),
    key<&UnitEntries::name>(
        "name", Any{},
        "Unit in which positions are shown. rotary: deg, rad or rev; linear: required, letters, "
        "such as mm, at most 16 bytes. m, cm, mm and um follow from each other."),
    key<&UnitEntries::per_revolution>(
        "per_revolution", Any{}, "rotary: user units in a revolution of the load, 1e-06 to 1e+09."),
    key<&UnitEntries::per_unit>("per_unit", Any{},
                                "linear: required, user units in one unit, 1e-06 to 1e+09."),
});

}  // namespace

void read_value(const YamlValue& value, const Any& /*rule*/, Unit& unit) {
  UnitEntries entries;
  read_section(value, kUnitRows, entries);
  const auto& [kind, name, per_revolution, per_unit] = entries;
  const bool is_linear = kind == UnitKind::linear;
  const auto& size = is_linear ? per_unit : per_revolution;
  const auto& other = is_linear ? per_revolution : per_unit;
  if (other) {
    other->refuse("cannot be used with kind: " + std::string(to_string(kind)) + "; use " +
                  std::string(size_key(kind)));
  }
  if (is_linear && (!name || !size)) {
    value.refuse(
        "a linear unit needs name and per_unit, such as {kind: linear, name: mm, "
        "per_unit: 819.2}");
  }
  unit = {.kind = kind};
  if (name) {
    unit.name = name->text();
    if (const auto problem = check_unit_name(kind, unit.name)) name->refuse(*problem);
  }
  if (size) unit.size = size->number({kSmallestUnit, kLargestUnit, "user units"});
}

void write_value(YAML::Emitter& out, const Any& /*rule*/, const Unit& unit) {
  out << YAML::BeginMap;
  out << YAML::Key << "kind" << YAML::Value << std::string(to_string(unit.kind));
  out << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << unit.name;
  out << YAML::Key << std::string(size_key(unit.kind)) << YAML::Value << to_text(unit.size);
  out << YAML::EndMap;
}

void describe_unit(const std::string& path, std::vector<ConfigurationKey>& keys) {
  describe_section(path + ".", kUnitRows, keys);
}

}  // namespace vdrive::settings
