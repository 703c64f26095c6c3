// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {

/// Words in messages.

/// @return such as "1 axis" or "3 axes".
[[nodiscard]] std::string counted(std::uint64_t count, std::string_view one, std::string_view many);

/// @return the least number of characters that have to be put in, taken out, replaced, or exchanged
///         with their neighbour, so that one text becomes the other.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// @return " (did you mean 'x'?)" with the candidate nearest to `text`, or nothing where none is
///         near: more than a third of the characters differ.
[[nodiscard]] std::string suggestion(std::string_view text,
                                     const std::vector<std::string>& candidates);

/// @return `text` with `prefix` before each of its lines: a program says so which lines are its
/// own.
[[nodiscard]] std::string prefixed_lines(std::string_view prefix, std::string_view text);

/// @return "{a,b}", how a help shows that a value is one of these words.
[[nodiscard]] std::string choice_of(const std::vector<std::string>& words);

/// @return why `text` is refused where it has to be one of these words, such as "air not in
///         {local,dds}", with the nearest word; empty where it is one of them.
[[nodiscard]] std::string refusal_of_choice(std::string_view text,
                                            const std::vector<std::string>& words);

/// Replaces a whole number by its decimal digits, for a reader that does not know the grammar of
/// vdrive/number_text.hpp.
/// @return why `text` is refused where it has to be a whole number from `lowest` to `highest`, such
///         as "'-1' must be a whole number from 0 to 232"; empty where it is one.
[[nodiscard]] std::string take_integer(std::string& text, std::int64_t lowest,
                                       std::int64_t highest);

}  // namespace vdrive
