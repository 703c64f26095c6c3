// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {

/// Wording of messages.

/// @return a text such as "1 axis" or "3 axes".
[[nodiscard]] std::string counted(std::uint64_t count, std::string_view one, std::string_view many);

/// @return the smallest number of characters to insert, delete, replace or swap with a neighbour
///         that turns one text into the other.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// @return " (did you mean 'x'?)" with the candidate closest to `text`, or nothing if in every
///         candidate more than a third of the characters differ.
[[nodiscard]] std::string suggestion(std::string_view text,
                                     const std::vector<std::string>& candidates);

/// @return `text` with `prefix` before each of its lines, so that a program can mark its own lines.
[[nodiscard]] std::string prefixed_lines(std::string_view prefix, std::string_view text);

/// @return "{a,b}", the form in which a help text lists the allowed words.
[[nodiscard]] std::string choice_of(const std::vector<std::string>& words);

/// @return why `text` is refused if it is not one of these words, such as "'air' must be one of
///         local, dds", with the closest word; empty if it is one of them. The text is not escaped:
///         escaped() is for the message as a whole.
[[nodiscard]] std::string refusal_of_choice(std::string_view text,
                                            const std::vector<std::string>& words);

/// Replaces a whole number with its decimal digits, for a parser that does not know the grammar of
/// vdrive/number_text.hpp.
/// @return why `text` is refused if it is not a whole number from `lowest` to `highest`, such as
///         "'-1' must be a whole number from 0 to 232"; empty if it is one.
[[nodiscard]] std::string take_integer(std::string& text, std::int64_t lowest,
                                       std::int64_t highest);

}  // namespace vdrive
