// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// Text of a given width on a terminal, in columns: a Chinese character takes two.

/// @return the width of `text`, which is UTF-8 without control characters.
[[nodiscard]] std::size_t display_width(std::string_view text);

/// @return `text`, padded with blanks on the right to `width`.
[[nodiscard]] std::string padded(std::string_view text, std::size_t width);

/// @return `text`, padded with blanks on the left to `width`.
[[nodiscard]] std::string aligned_right(std::string_view text, std::size_t width);

/// @return `text`; if it is wider than `width`, its beginning and "..".
[[nodiscard]] std::string clipped(std::string_view text, std::size_t width);

/// @param rows may have different numbers of columns
/// @return each row as a line, with at least two blanks between columns and no trailing blanks.
[[nodiscard]] std::vector<std::string> table_lines(
    const std::vector<std::vector<std::string>>& rows, std::string_view indent = "");

}  // namespace vdrive::tool
