// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings/yaml_reader.hpp"
#include "vdrive/assert.hpp"
#include "vdrive/number_text.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace vdrive::settings {

// The keys of a YAML file as rows of a table, with functions that read, check, print and describe
// them. The service and the bridges define all their keys in such tables.

/// A key with its place in the file, for the help.
struct ConfigurationKey {
  std::string path;  ///< such as "clock.period_us", "axes[].name"
  std::string what;  ///< values, unit, limits and meaning
};

// ---- what a value may be -----------------------------------------------------------------------

/// Any value that has the type of its place. The place of a value is the member of a settings
/// object that receives it.
struct Any {};

/// A text that must meet further conditions.
struct TextRule {
  std::string_view if_empty{};  ///< error for an empty text; empty = an empty text is allowed
  bool (*fits)(const std::string&) = nullptr;  ///< nullptr = every other text fits
  std::string_view refusal{};                  ///< error for a text that does not fit
  bool is_quoted = false;                      ///< whether it is printed in quotes
};

/// A whole number, or a word for none.
struct IntegerOrNone {
  IntegerLimits limits;
  std::string_view none;
};

/// The rule for the value of a key, or for each element if the value is a list.
using Rule = std::variant<Any, IntegerLimits, NumberLimits, Choices, TextRule, IntegerOrNone>;

template <auto... kValues>
inline constexpr std::array kNamesOf{Choice{to_string(kValues), static_cast<int>(kValues)}...};

/// One of these values, by the names that to_string() gives them.
template <auto... kValues>
inline constexpr Choices kOneOf = kNamesOf<kValues...>;

template <typename T>
concept Whole = std::integral<T> || requires {
  typename T::period;
};

template <typename T>
concept Text = std::same_as<T, std::string> || std::same_as<T, std::filesystem::path>;

// ---- from a file to the place ------------------------------------------------------------------
// A type with its own syntax has its own read_value(), and write_value() if it is printed. Each
// throws ConfigurationError if the value breaks the rule.

inline void read_value(const YamlValue& value, const Any& /*rule*/, bool& place) {
  place = value.boolean();
}

inline void read_value(const YamlValue& value, const Any& /*rule*/, double& place) {
  place = value.number("");
}

inline void read_value(const YamlValue& value, const NumberLimits& limits, double& place) {
  place = value.number(limits);
}

template <Whole T>
void read_value(const YamlValue& value, const IntegerLimits& limits, T& place) {
  place = static_cast<T>(value.integer(limits));
}

template <typename T>
requires std::is_enum_v<T>

void read_value(const YamlValue& value, const Choices& choices, T& place) {
  place = static_cast<T>(value.choice(choices));
}

template <Text T>
void read_value(const YamlValue& value, const Any& /*rule*/, T& place) {
  place = value.text();
}

template <Text T>
void read_value(const YamlValue& value, const TextRule& rule, T& place) {
  std::string text = value.text();
  if (text.empty() && !rule.if_empty.empty()) value.refuse(std::string(rule.if_empty));
  if (rule.fits != nullptr && !rule.fits(text)) value.refuse(std::string(rule.refusal));
  place = std::move(text);
}

/// Keeps a value that can only be read once others are known.
inline void read_value(const YamlValue& value, const Any& /*rule*/,
                       std::optional<YamlValue>& place) {
  place.emplace(value);
}

template <typename R, typename T>
void read_value(const YamlValue& value, const R& rule, std::optional<T>& place) {
  read_value(value, rule, place.emplace());
}

template <Whole T>
void read_value(const YamlValue& value, const IntegerOrNone& rule, std::optional<T>& place) {
  place.reset();
  if (value.text() != rule.none) read_value(value, rule.limits, place.emplace());
}

/// The list replaces the content of the place.
template <typename R, typename T>
void read_value(const YamlValue& list, const R& rule, std::vector<T>& place) {
  place.clear();
  list.for_each_element([&](const YamlValue& element) {
    read_value(element, rule, place.emplace_back());
  });
}

// ---- from the place to a file ------------------------------------------------------------------

template <typename R, typename T>
concept Printable = requires(YAML::Emitter& out, const R& rule, const T& place) {
  write_value(out, rule, place);
};

inline void write_value(YAML::Emitter& out, const Any& /*rule*/, bool place) {
  out << place;
}

inline void write_value(YAML::Emitter& out, const Any& /*rule*/, double place) {
  out << to_text(place);
}

inline void write_value(YAML::Emitter& out, const NumberLimits& /*limits*/, double place) {
  out << to_text(place);
}

template <Whole T>
void write_value(YAML::Emitter& out, const IntegerLimits& /*limits*/, T place) {
  if constexpr (std::integral<T>) {
    out << static_cast<std::int64_t>(place);
  } else {
    out << static_cast<std::int64_t>(place.count());
  }
}

template <typename T>
requires std::is_enum_v<T>

void write_value(YAML::Emitter& out, const Choices& choices, T place) {
  const auto choice = std::ranges::find(choices, static_cast<int>(place), &Choice::value);
  ensure(choice != choices.end(), "each value has a name");
  out << std::string(choice->name);
}

inline void write_value(YAML::Emitter& out, const Any& /*rule*/, const std::string& place) {
  out << place;
}

inline void write_value(YAML::Emitter& out, const TextRule& rule, const std::string& place) {
  if (rule.is_quoted) out << YAML::DoubleQuoted;
  out << place;
}

template <typename R, typename T>
requires Printable<R, T>

void write_value(YAML::Emitter& out, const R& rule, const std::optional<T>& place) {
  write_value(out, rule, *place);
}

template <Whole T>
void write_value(YAML::Emitter& out, const IntegerOrNone& rule, const std::optional<T>& place) {
  if (place) {
    write_value(out, rule.limits, *place);
  } else {
    out << std::string(rule.none);
  }
}

template <typename R, typename T>
requires Printable<R, T>

void write_value(YAML::Emitter& out, const R& rule, const std::vector<T>& place) {
  out << YAML::Flow << YAML::BeginSeq;
  for (const T& element : place) write_value(out, rule, element);
  out << YAML::EndSeq;
}

/// @return whether there is something to print: false for an empty text, and for nullopt unless the
///         rule has a word for it.
template <typename R, typename T>
[[nodiscard]] bool is_given(const T& place) {
  if constexpr (Text<T>) {
    return !place.empty();
  } else if constexpr (requires { place.has_value(); } && !std::same_as<R, IntegerOrNone>) {
    return place.has_value();
  } else {
    return true;
  }
}

// ---- the rows ----------------------------------------------------------------------------------

/// Everything about a key of a map whose value belongs to an `Owner`.
template <typename Owner>
struct Row {
  std::string_view key{};

  /// Values, unit, limits and meaning, for the help; "{}" stands for the limits. Empty for
  /// sections, and for keys whose help no program shows.
  std::string_view what{};

  Rule rule{};

  /// Error for a map without the key; empty = the key may be left out.
  std::string_view needed{};

  /// Reads the value into its place; nullptr = `then` does everything.
  void (*read)(const YamlValue& value, const Rule& rule, Owner& owner) = nullptr;

  /// Checks the value together with others, or computes what follows from it.
  void (*then)(const YamlValue& value, Owner& owner) = nullptr;

  /// Prints the value; nullptr = the key is not printed.
  void (*write)(YAML::Emitter& out, const Rule& rule, const Owner& owner) = nullptr;

  /// Decides whether the key is printed; nullptr = always.
  bool (*is_printed)(const Owner& owner) = nullptr;

  /// Adds to the help instead of `what`: a section adds its keys.
  void (*describe)(const std::string& path, std::vector<ConfigurationKey>& keys) = nullptr;
};

/// @return the keys of the rows, in their order.
[[nodiscard]] std::vector<std::string_view> keys_of(const auto& rows) {
  std::vector<std::string_view> keys;
  keys.reserve(std::size(rows));
  for (const auto& row : rows) keys.push_back(row.key);
  return keys;
}

/// Reads the value of a key, which must have a row.
template <typename Owner>
void read_key(const auto& rows, std::string_view key, const YamlValue& value, Owner& owner) {
  const auto row = std::ranges::find(rows, key, &Row<Owner>::key);
  ensure(row != std::ranges::end(rows), "a known key has a row");
  if (row->read != nullptr) row->read(value, row->rule, owner);
  if (row->then != nullptr) row->then(value, owner);
}

/// Reads a map whose keys have rows.
/// @throws ConfigurationError if a key is unknown or appears twice, its row refuses the value, or a
///         required key is missing
template <typename Owner>
void read_section(const YamlValue& map, const auto& rows, Owner& owner) {
  std::vector<std::string> given;
  map.for_each_entry(keys_of(rows), [&](const std::string& key, const YamlValue& value) {
    given.push_back(key);
    read_key(rows, key, value, owner);
  });
  for (const Row<Owner>& row : rows) {
    const bool is_missing = !row.needed.empty() && std::ranges::find(given, row.key) == given.end();
    if (is_missing) map.refuse(std::string(row.needed));
  }
}

template <typename Owner>
[[nodiscard]] bool is_printed(const Row<Owner>& row, const Owner& owner) {
  return row.write != nullptr && (row.is_printed == nullptr || row.is_printed(owner));
}

template <typename Owner>
void write_section(YAML::Emitter& out, const auto& rows, const Owner& owner) {
  out << YAML::BeginMap;
  for (const Row<Owner>& row : rows) {
    if (!is_printed(row, owner)) continue;
    out << YAML::Key << std::string(row.key) << YAML::Value;
    row.write(out, row.rule, owner);
  }
  out << YAML::EndMap;
}

/// @return the help of a key, with its limits.
[[nodiscard]] inline std::string help_text(std::string_view what, const Rule& rule) {
  std::string text(what);
  const auto place = text.find("{}");
  if (place == std::string::npos) return text;
  const auto* const or_none = std::get_if<IntegerOrNone>(&rule);
  const auto& limits = or_none != nullptr ? or_none->limits : std::get<IntegerLimits>(rule);
  return text.replace(place, 2,
                      std::to_string(limits.lowest) + " to " + std::to_string(limits.highest));
}

/// Adds the keys of rows, whose paths begin with `prefix`.
void describe_section(const std::string& prefix, const auto& rows,
                      std::vector<ConfigurationKey>& keys) {
  for (const auto& row : rows) {
    const std::string path = prefix + std::string(row.key);
    if (row.describe != nullptr) {
      row.describe(path, keys);
    } else {
      keys.push_back({path, help_text(row.what, row.rule)});
    }
  }
}

template <typename Member>
struct OwnerOfMember;

template <typename Owner, typename Member>
struct OwnerOfMember<Member Owner::*> {
  using Type = Owner;
};

template <auto kMember>
using OwnerOf = typename OwnerOfMember<decltype(kMember)>::Type;

/// @return the member to which a chain of member pointers leads.
template <auto kMember, auto... kFurther>
[[nodiscard]] constexpr auto& place_in(auto& owner) {
  if constexpr (sizeof...(kFurther) == 0) {
    return owner.*kMember;
  } else {
    return place_in<kFurther...>(owner.*kMember);
  }
}

/// @tparam kMember together with kFurther, leads from the owner to the place of the value, such as
///         &Configuration::network, &NetworkSettings::domain
/// @param row the other properties of the key
template <auto kMember, auto... kFurther, typename R = Any>
[[nodiscard]] constexpr auto key(std::string_view name, const R& rule = {},
                                 std::string_view what = {}, Row<OwnerOf<kMember>> row = {}) {
  using Owner = OwnerOf<kMember>;
  using Place =
      std::remove_cvref_t<decltype(place_in<kMember, kFurther...>(std::declval<Owner&>()))>;
  Row<Owner> made{.key = name,
                  .what = what,
                  .rule = rule,
                  .needed = row.needed,
                  .read =
                      [](const YamlValue& value, const Rule& of_row, Owner& owner) {
                        read_value(value, std::get<R>(of_row),
                                   place_in<kMember, kFurther...>(owner));
                      },
                  .then = row.then,
                  .is_printed = row.is_printed,
                  .describe = row.describe};
  if constexpr (Printable<R, Place>) {
    made.write = [](YAML::Emitter& out, const Rule& of_row, const Owner& owner) {
      write_value(out, std::get<R>(of_row), place_in<kMember, kFurther...>(owner));
    };
    if (made.is_printed == nullptr) {
      made.is_printed = [](const Owner& owner) {
        return is_given<R>(place_in<kMember, kFurther...>(owner));
      };
    }
  }
  return made;
}

/// A key whose value is a map with its own rows. A section with nothing to print is not printed.
/// @tparam kMember together with kFurther, leads from the owner to the owner of the rows
/// @param row the other properties of the key
template <const auto& kRows, auto kMember, auto... kFurther>
[[nodiscard]] constexpr auto section(std::string_view name, Row<OwnerOf<kMember>> row = {}) {
  using Owner = OwnerOf<kMember>;
  row.key = name;
  row.read = [](const YamlValue& value, const Rule& /*rule*/, Owner& owner) {
    read_section(value, kRows, place_in<kMember, kFurther...>(owner));
  };
  row.write = [](YAML::Emitter& out, const Rule& /*rule*/, const Owner& owner) {
    write_section(out, kRows, place_in<kMember, kFurther...>(owner));
  };
  row.is_printed = [](const Owner& owner) {
    return std::ranges::any_of(kRows, [&owner](const auto& part) {
      return is_printed(part, place_in<kMember, kFurther...>(owner));
    });
  };
  row.describe = [](const std::string& path, std::vector<ConfigurationKey>& keys) {
    describe_section(path + ".", kRows, keys);
  };
  return row;
}

}  // namespace vdrive::settings
