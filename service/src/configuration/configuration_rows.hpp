// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings/yaml_reader.hpp"
#include "vdrive/assert.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace vdrive::service {

using settings::IntegerLimits;
using settings::YamlValue;

/// A key of a configuration in YAML, but for the objects of `axes[].parameters`.
struct ConfigurationKey {
  std::string path;  ///< such as "clock.period_us", "axes[].name"
  std::string what;  ///< values, unit, limits and meaning
};

/// A key of a map of the configuration, whose value belongs to an `Owner`: all that the program
/// knows of the key. A section is a key whose value is a map with rows of its own.
template <typename Owner>
struct ConfigurationRow {
  std::string_view key;

  /// Values, unit, limits and meaning, for the help; "{}" stands for `limits`. Empty for a section.
  std::string_view what{};

  std::optional<IntegerLimits> limits{};

  /// Takes a whole number within `limits`.
  void (*set)(Owner& owner, std::int64_t value) = nullptr;

  /// Takes a value that `set` cannot: one that is not, or not only, a whole number. Then there is
  /// no `set`.
  void (*read)(const YamlValue& value, Owner& owner) = nullptr;

  /// Prints the value.
  void (*write)(YAML::Emitter& out, const Owner& owner) = nullptr;

  /// Whether the key is printed at all; nullptr = always.
  bool (*is_printed)(const Owner& owner) = nullptr;

  /// Of a section: adds its keys, whose paths begin with `prefix`.
  void (*describe)(const std::string& prefix, std::vector<ConfigurationKey>& keys) = nullptr;
};

/// @return the row of a whole number that is a member of the owner.
template <typename Owner, auto kMember>
[[nodiscard]] constexpr ConfigurationRow<Owner> integer_row(std::string_view key,
                                                            const IntegerLimits& limits,
                                                            std::string_view what) {
  return {.key = key,
          .what = what,
          .limits = limits,
          .set =
              [](Owner& owner, std::int64_t value) {
                using Member = std::remove_reference_t<decltype(owner.*kMember)>;
                owner.*kMember = static_cast<Member>(value);
              },
          .write =
              [](YAML::Emitter& out, const Owner& owner) {
                out << owner.*kMember;
              }};
}

/// @return the row of a member that is true or false.
template <typename Owner, auto kMember>
[[nodiscard]] constexpr ConfigurationRow<Owner> boolean_row(std::string_view key,
                                                            std::string_view what) {
  return {.key = key,
          .what = what,
          .read =
              [](const YamlValue& value, Owner& owner) {
                owner.*kMember = value.boolean();
              },
          .write =
              [](YAML::Emitter& out, const Owner& owner) {
                out << owner.*kMember;
              }};
}

/// @return the keys of the rows in their order.
template <typename Owner>
[[nodiscard]] std::vector<std::string_view> keys_of(std::span<const ConfigurationRow<Owner>> rows) {
  std::vector<std::string_view> keys;
  for (const auto& row : rows) keys.push_back(row.key);
  return keys;
}

/// Reads one value by its row.
template <typename Owner>
void read_key(const ConfigurationRow<Owner>& row, const YamlValue& value, Owner& owner) {
  if (row.set != nullptr) {
    row.set(owner, value.integer(*row.limits));
  } else {
    row.read(value, owner);
  }
}

/// @return the row of a key that was found among the known ones.
template <typename Owner>
[[nodiscard]] const ConfigurationRow<Owner>& row_of_known(
    std::span<const ConfigurationRow<Owner>> rows, std::string_view key) {
  const auto row = std::ranges::find(rows, key, &ConfigurationRow<Owner>::key);
  ensure(row != rows.end(), "a known key has a row");
  return *row;
}

/// Reads a map whose keys have rows.
/// @throws ConfigurationError when a key is unknown or appears twice, or its row refuses the value.
template <typename Owner>
void read_section(const YamlValue& map, std::span<const ConfigurationRow<Owner>> rows,
                  Owner& owner) {
  const auto known = keys_of(rows);
  map.for_each_entry(known, [&](const std::string& key, const YamlValue& value) {
    read_key(row_of_known(rows, key), value, owner);
  });
}

/// Prints the entries of a map, not its beginning and end.
template <typename Owner>
void write_entries(YAML::Emitter& out, std::span<const ConfigurationRow<Owner>> rows,
                   const Owner& owner) {
  for (const auto& row : rows) {
    if (row.is_printed != nullptr && !row.is_printed(owner)) continue;
    out << YAML::Key << std::string(row.key) << YAML::Value;
    row.write(out, owner);
  }
}

template <typename Owner>
void write_section(YAML::Emitter& out, std::span<const ConfigurationRow<Owner>> rows,
                   const Owner& owner) {
  out << YAML::BeginMap;
  write_entries(out, rows, owner);
  out << YAML::EndMap;
}

/// @return the help of a row, with its limits.
template <typename Owner>
[[nodiscard]] std::string text_of(const ConfigurationRow<Owner>& row) {
  std::string text(row.what);
  const auto place = text.find("{}");
  if (place == std::string::npos || !row.limits) return text;
  return text.replace(
      place, 2, std::to_string(row.limits->lowest) + " to " + std::to_string(row.limits->highest));
}

template <typename Owner>
void describe_section(const std::string& prefix, std::span<const ConfigurationRow<Owner>> rows,
                      std::vector<ConfigurationKey>& keys) {
  for (const auto& row : rows) {
    if (row.describe != nullptr) {
      row.describe(prefix + std::string(row.key), keys);
    } else {
      keys.push_back({prefix + std::string(row.key), text_of(row)});
    }
  }
}

}  // namespace vdrive::service
