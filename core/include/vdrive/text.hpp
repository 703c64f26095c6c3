// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {

/// Text in messages that comes from a file, a command line or another program.

/// How much of a value a message shows.
inline constexpr std::size_t kShownOfValue = 64;  // [characters]

/// How much of a file's name, or of another library's message, a message shows.
inline constexpr std::size_t kShownOfMessage = 400;  // [characters]

/// How large a file of settings may be: that of a bench of 16,384 axes with 250 bytes for each.
inline constexpr std::size_t kLargestSettingsFile = std::size_t{4} << 20U;  // [bytes]

/// @return `text` as one line without control characters: \n, \r, \t and \\ are written so; other
///         control characters (of ASCII and U+0080 to U+009F), characters that break or reorder
///         lines (U+2028 to U+202E, U+2066 to U+2069) and bytes that are not UTF-8 as \xNN. Of a
///         text with more than `longest` characters the first three quarters and the last quarter
///         of that number, with "..." between.
[[nodiscard]] std::string escaped(std::string_view text, std::size_t longest = kShownOfValue);

/// @return `escaped(text)` in single quotes; the number of bytes follows where it was shortened.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// @return the words one after the other, with `separator` between them.
[[nodiscard]] std::string joined(const std::vector<std::string>& words,
                                 std::string_view separator = ", ");

/// @return whether `text` is well-formed UTF-8 (RFC 3629).
[[nodiscard]] bool is_utf8(std::string_view text) noexcept;

/// @return whether `text` begins as UTF-16 or UTF-32 does: with a byte order mark of these, or with
///         a zero among its first four bytes.
[[nodiscard]] bool is_wide_text(std::string_view text) noexcept;

}  // namespace vdrive
