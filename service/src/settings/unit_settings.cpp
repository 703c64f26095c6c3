// SPDX-License-Identifier: Apache-2.0
#include "settings/unit_settings.hpp"

#include "vdrive/number_text.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace vdrive::settings {
namespace {

/// The key that has the size of a unit of this kind.
std::string_view size_key(UnitKind kind) {
  return kind == UnitKind::rotary ? "per_revolution" : "per_unit";
}

/// What a `unit` of the configuration has, each with its place.
struct UnitEntries {
  std::optional<UnitKind> kind{};
  std::optional<YamlValue> name{};
  std::optional<YamlValue> per_revolution{};
  std::optional<YamlValue> per_unit{};
};

UnitKind read_kind(const YamlValue& value) {
  const bool is_rotary =
      value.choice({to_string(UnitKind::rotary), to_string(UnitKind::linear)}) == 0;
  return is_rotary ? UnitKind::rotary : UnitKind::linear;
}

UnitEntries read_entries(const YamlValue& value) {
  UnitEntries entries;
  value.for_each_entry({"kind", "name", "per_revolution", "per_unit"},
                       [&](const auto& key, const YamlValue& entry) {
                         if (key == "kind") {
                           entries.kind = read_kind(entry);
                         } else if (key == "name") {
                           entries.name.emplace(entry);
                         } else if (key == "per_revolution") {
                           entries.per_revolution.emplace(entry);
                         } else {
                           entries.per_unit.emplace(entry);
                         }
                       });
  return entries;
}

}  // namespace

Unit read_unit(const YamlValue& value) {
  const auto [kind, name, per_revolution, per_unit] = read_entries(value);
  if (!kind) value.refuse("a unit needs a kind: rotary or linear");
  const bool is_linear = *kind == UnitKind::linear;
  const auto& size = is_linear ? per_unit : per_revolution;
  const auto& other = is_linear ? per_revolution : per_unit;
  if (other) {
    other->refuse("belongs to the other kind; a " + std::string(to_string(*kind)) + " unit has " +
                  std::string(size_key(*kind)));
  }
  if (is_linear && (!name || !size)) {
    value.refuse(
        "a linear unit needs name and per_unit, such as {kind: linear, name: mm, "
        "per_unit: 819.2}");
  }
  Unit unit{.kind = *kind};
  if (name) {
    unit.name = name->text();
    if (const auto problem = check_unit_name(*kind, unit.name)) name->refuse(*problem);
  }
  if (size) unit.size = size->number({kSmallestUnit, kLargestUnit, "user units"});
  return unit;
}

void write_unit(YAML::Emitter& out, const Unit& unit) {
  out << YAML::BeginMap;
  out << YAML::Key << "kind" << YAML::Value << std::string(to_string(unit.kind));
  out << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << unit.name;
  out << YAML::Key << std::string(size_key(unit.kind)) << YAML::Value << to_text(unit.size);
  out << YAML::EndMap;
}

}  // namespace vdrive::settings
