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

/// @return the text of a settings file.
/// @throws ConfigurationError naming the file, if it cannot be read or is larger than
///         `kLargestSettingsFile`
[[nodiscard]] std::string read_yaml_file(const std::filesystem::path& file);

/// Parses a file that consists of one YAML document in UTF-8, with limits on its depth and on its
/// size after all aliases are expanded.
/// @return the document, null if there is none
/// @throws ConfigurationError naming the file and the line, if `text` is anything else
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

/// A value of a YAML document, with the file and the key for error messages.
class YamlValue {
 public:
  YamlValue(const YAML::Node& node, std::string file, std::string path)
      : node_(node), file_(std::move(file)), path_(std::move(path)) {}

  /// Calls `visit(key, value)` for each entry of a map, including those after an entry with a
  /// mistake.
  /// @throws ConfigurationError if this is not a map; at the end, with the mistakes of all entries:
  ///         keys that are not in `known` (empty = any key) or are repeated, and whatever `visit`
  ///         has thrown
  void for_each_entry(std::span<const std::string_view> known,
                      const std::function<void(const std::string&, const YamlValue&)>& visit) const;

  /// Calls `visit(value)` for each element of a list, including those after one with a mistake.
  /// @throws ConfigurationError if this is not a list; at the end, whatever `visit` has thrown
  void for_each_element(const std::function<void(const YamlValue&)>& visit) const;

  /// @throws ConfigurationError if this is not a whole number (decimal or 0x...) within the limits
  [[nodiscard]] std::int64_t integer(const IntegerLimits& limits) const;

  /// @throws ConfigurationError if this is not a finite number
  [[nodiscard]] double number(std::string_view unit) const;

  /// @throws ConfigurationError if this is not a finite number within the limits
  [[nodiscard]] double number(const NumberLimits& limits) const;

  /// @throws ConfigurationError if this is neither true nor false
  [[nodiscard]] bool boolean() const;

  /// @throws ConfigurationError if this is not a scalar
  [[nodiscard]] std::string text() const;

  /// @return whether this is a map of keys and values.
  [[nodiscard]] bool is_map() const { return node_.IsMap(); }

  /// @return the value of the choice with this name.
  /// @throws ConfigurationError naming the choices, if this is none of them
  [[nodiscard]] int choice(const Choices& choices) const;

  /// @return the line in the file, from 1.
  [[nodiscard]] int line() const;

  /// @return a message with file, line, key, value and `problem`.
  [[nodiscard]] std::string message(const std::string& problem) const;

  /// @throws ConfigurationError with that message
  [[noreturn]] void refuse(const std::string& problem) const;

 private:
  YAML::Node node_;
  std::string file_;
  std::string path_;  ///< of the key, such as clock.period_us
};

}  // namespace vdrive::settings
