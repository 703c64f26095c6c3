// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

// What a scenario may have at most: a mistake, or a file of another kind, is found before it takes
// memory or time. The largest sensible line names each of some thousand axes.

/// Bytes of a line, with the values in the places of its variables, too.
inline constexpr std::size_t kLongestLine = std::size_t{32} << 10U;

/// Words of a line.
inline constexpr std::size_t kMostWords = 4'096;

/// Bytes of a file, with the values in the places of its variables, too.
inline constexpr std::size_t kLargestScenario = std::size_t{4} << 20U;

/// The variables of one scenario: what `--set` of the command line gives takes precedence over what
/// `let` of the file gives.
class Variables {
 public:
  using Values = std::map<std::string, std::string>;

  /// @param settings of the command line, from settings_of()
  explicit Variables(Values settings = {}) : settings_(std::move(settings)) {}

  /// Takes a line such as `let speed = 500`. @return whether it is such a line.
  /// @throws UsageError when name or value are not valid.
  bool let(std::string_view line);

  /// @return `line` with the value in the place of each ${name}.
  /// @throws UsageError for a variable that has no value, and for more than kLongestLine bytes.
  [[nodiscard]] std::string expand(std::string_view line);

  /// The variables that the scenario uses or gives a value.
  [[nodiscard]] const std::set<std::string>& names() const noexcept { return names_; }

 private:
  [[nodiscard]] const std::string& value_of(const std::string& name);

  Values settings_;
  Values defaults_;
  std::set<std::string> names_;
};

/// @param texts such as `axis=7.1`
/// @throws UsageError naming the text that has another form, or the variable that is set twice.
[[nodiscard]] Variables::Values settings_of(const std::vector<std::string>& texts);

}  // namespace vdrive::tool
