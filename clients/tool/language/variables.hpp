// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

// Limits of a scenario, so that a mistake, or a file of another kind, is found before it takes much
// memory or time. The longest sensible line names some thousand axes.

/// Longest line [bytes], before and after its variables are replaced.
inline constexpr std::size_t kLongestLine = std::size_t{32} << 10U;

/// Most words in a line.
inline constexpr std::size_t kMostWords = 4'096;

/// Largest file [bytes], before and after its variables are replaced.
inline constexpr std::size_t kLargestScenario = std::size_t{4} << 20U;

/// The variables of one scenario: values from `--set` on the command line take precedence over
/// those from `let` in the file.
class Variables {
 public:
  using Values = std::map<std::string, std::string>;

  /// @param settings of the command line, from settings_of()
  explicit Variables(Values settings = {}) : settings_(std::move(settings)) {}

  /// Handles a line such as `let speed = 500`.
  /// @return whether it is such a line.
  /// @throws UsageError if name or value is not valid.
  bool let(std::string_view line);

  /// @return `line` with each ${name} replaced by its value.
  /// @throws UsageError for a variable without a value, and for more than kLongestLine bytes.
  [[nodiscard]] std::string expand(std::string_view line);

  /// The variables that the scenario uses or sets.
  [[nodiscard]] const std::set<std::string>& names() const noexcept { return names_; }

 private:
  [[nodiscard]] const std::string& value_of(const std::string& name);

  Values settings_;
  Values defaults_;
  std::set<std::string> names_;
};

/// @param texts such as `axis=7.1`
/// @throws UsageError with the text, if it has another form or sets a variable twice.
[[nodiscard]] Variables::Values settings_of(const std::vector<std::string>& texts);

}  // namespace vdrive::tool
