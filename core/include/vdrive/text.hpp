// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {

/// Formatting of text from a file, a command line or another program for use in messages.

/// How much of a value a message shows.
inline constexpr std::size_t kShownOfValue = 64;  // [characters]

/// How much of a file name, or of another library's message, a message shows.
inline constexpr std::size_t kShownOfMessage = 400;  // [characters]

/// Largest settings file: enough for a bench of 16,384 axes with 250 bytes for each.
inline constexpr std::size_t kLargestSettingsFile = std::size_t{4} << 20U;  // [bytes]

/// @return `text` as one line without control characters: line feed, carriage return, tab and
///         backslash are shown as \n, \r, \t and \\; other control characters (ASCII and U+0080 to
///         U+009F), characters that break or reorder lines (U+2028 to U+202E, U+2066 to U+2069) and
///         bytes that are not UTF-8 as \xNN. Of a text longer than `longest` characters, only the
///         first three quarters and the last quarter of that number are kept, with "..." between
///         them.
[[nodiscard]] std::string escaped(std::string_view text, std::size_t longest = kShownOfValue);

/// @return `escaped(text)` in single quotes, followed by the number of bytes if it was shortened.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// @return the words in order, with `separator` between them.
[[nodiscard]] std::string joined(const std::vector<std::string>& words,
                                 std::string_view separator = ", ");

/// @return whether `text` is well-formed UTF-8 (RFC 3629).
[[nodiscard]] bool is_utf8(std::string_view text) noexcept;

/// @return whether `text` starts like UTF-16 or UTF-32: with one of their byte order marks, or with
///         a zero among its first four bytes.
[[nodiscard]] bool is_wide_text(std::string_view text) noexcept;

}  // namespace vdrive
