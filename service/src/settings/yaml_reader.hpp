// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::settings {

/// @return the text of a file of settings.
/// @throws ConfigurationError that names the file, when it cannot be read or has more bytes than
///         `kLargestSettingsFile`.
[[nodiscard]] std::string read_yaml_file(const std::filesystem::path& file);

/// Parses a file that is one YAML document in UTF-8, of bounded depth and, with every alias
/// replaced by what it names, of bounded length.
/// @return the document, null where there is none.
/// @throws ConfigurationError that names the file and the line, when `text` is anything else.
[[nodiscard]] YAML::Node read_yaml(const std::string& text, const std::string& file_name);

/// Limits of a whole number.
struct IntegerLimits {
  std::int64_t lowest;
  std::int64_t highest;
  std::string_view unit;  ///< empty = none
};

/// Limits of a number.
struct NumberLimits {
  double lowest;
  double highest;
  std::string_view unit;  ///< empty = none
};

/// A name that stands for a value.
struct Choice {
  std::string_view name;
  int value;
};

using Choices = std::span<const Choice>;

/// A value of a YAML document with its file and its key, which every error about it names.
class YamlValue {
 public:
  YamlValue(const YAML::Node& node, std::string file, std::string path)
      : node_(node), file_(std::move(file)), path_(std::move(path)) {}

  /// Calls `visit(key, value)` for each entry of a map, also behind an entry with a mistake.
  /// @throws ConfigurationError when this is not a map; at the end, with the mistakes of all
  ///         entries: a key that is not in `known` (empty = any key) or is repeated, and what
  ///         `visit` throws.
  void for_each_entry(std::span<const std::string_view> known,
                      const std::function<void(const std::string&, const YamlValue&)>& visit) const;

  /// Calls `visit(value)` for each element of a list, also behind an element with a mistake.
  /// @throws ConfigurationError when this is no list; at the end, what `visit` has thrown.
  void for_each_element(const std::function<void(const YamlValue&)>& visit) const;

  /// @throws ConfigurationError when this is no whole number (decimal or 0x...) within the limits.
  [[nodiscard]] std::int64_t integer(const IntegerLimits& limits) const;

  /// @throws ConfigurationError when this is no finite number.
  [[nodiscard]] double number(std::string_view unit) const;

  /// @throws ConfigurationError when this is no finite number within the limits.
  [[nodiscard]] double number(const NumberLimits& limits) const;

  /// @throws ConfigurationError when this is not true or false.
  [[nodiscard]] bool boolean() const;

  /// @throws ConfigurationError when this is no scalar.
  [[nodiscard]] std::string text() const;

  /// @return whether this is a map of keys and values.
  [[nodiscard]] bool is_map() const { return node_.IsMap(); }

  /// @return the value whose name this is.
  /// @throws ConfigurationError naming the choices, when it is none of them.
  [[nodiscard]] int choice(const Choices& choices) const;

  /// @return the line of the file, from 1.
  [[nodiscard]] int line() const;

  /// @return file, line, key, value, and `problem`.
  [[nodiscard]] std::string message(const std::string& problem) const;

  /// @throws ConfigurationError with that message.
  [[noreturn]] void refuse(const std::string& problem) const;

 private:
  YAML::Node node_;
  std::string file_;
  std::string path_;  ///< key as in clock.period_us
};

}  // namespace vdrive::settings
