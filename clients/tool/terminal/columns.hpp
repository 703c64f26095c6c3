// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::tool {

/// Text of a given width on a terminal. Widths are columns: a Chinese character takes two.

/// @return the columns that `text` takes; `text` is UTF-8 without control characters.
[[nodiscard]] std::size_t display_width(std::string_view text);

/// @return `text`, followed by blanks where it is narrower than `width`.
[[nodiscard]] std::string padded(std::string_view text, std::size_t width);

/// @return `text`, after blanks where it is narrower than `width`.
[[nodiscard]] std::string aligned_right(std::string_view text, std::size_t width);

/// @return `text`, or its beginning and ".." where it is wider than `width`.
[[nodiscard]] std::string clipped(std::string_view text, std::size_t width);

/// @param rows a row may have fewer columns than the others
/// @return each row as a line, its columns two blanks or more apart, without blanks at its end.
[[nodiscard]] std::vector<std::string> table_lines(
    const std::vector<std::vector<std::string>>& rows, std::string_view indent = "");

}  // namespace vdrive::tool
