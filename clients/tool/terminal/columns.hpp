// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

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

}  // namespace vdrive::tool
