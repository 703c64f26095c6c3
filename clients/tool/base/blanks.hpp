// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

namespace vdrive::tool {

/// The characters that separate words of a line.
inline constexpr std::string_view kBlanks = " \t\r\f\v";

/// @return `text` without leading and trailing blanks.
[[nodiscard]] inline std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace vdrive::tool
