// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace vdrive {

/// @return the number if `text` consists of its digits only, otherwise nothing.
/// @param base 10 or 16; a prefix is not accepted
template <std::integral Number>
[[nodiscard]] std::optional<Number> parse_digits(std::string_view text, int base = 10) noexcept {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number, base);
  return error == std::errc{} && stop == end ? std::optional(number) : std::nullopt;
}

/// The grammar of numbers and durations written by people, the same in every program, file and
/// language of vdrive (docs/reference/numbers.md):
///
///     number   = decimal | "0x" 1*hex-digit             such as -500, 12.5, 1e6 or 0x1F
///     decimal  = ["-"] digits ["e" ["-" | "+"] 1*digit]
///     digits   = 1*digit ["." *digit] | "." 1*digit
///     duration = digits ["e" ["-" | "+"] 1*digit] [*" " unit]   such as 20ms, 1.5 s or 5
///     unit     = "us" | "ms" | "s" | "min" | "h"        without one: seconds
///
/// Case does not matter in "0x", "e" and hex digits.

/// @return whether `text` begins with 0x.
[[nodiscard]] bool has_hex_prefix(std::string_view text) noexcept;

/// Whether a text is a whole number and, if not, why.
enum class IntegerKind : std::uint8_t {
  whole,
  fraction,   ///< a number such as 12.5
  too_large,  ///< a whole number that does not fit in a signed 64-bit integer
  no_number,
};

/// The result of reading a text as a whole number.
struct IntegerReading {
  IntegerKind kind = IntegerKind::no_number;
  std::int64_t value = 0;  ///< if `kind` is whole
};

/// Reads a whole number exactly: 1e6 and 2.0 are whole, 12.5 is not.
[[nodiscard]] IntegerReading read_integer(std::string_view text);

/// @return the whole number that `text` spells, or nothing.
[[nodiscard]] std::optional<std::int64_t> parse_integer(std::string_view text);

/// @return the finite number that `text` spells, or nothing.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// @return the length of the decimal number at the start of `text` [characters], 0 = none. A unit
///         may follow.
[[nodiscard]] std::size_t decimal_length(std::string_view text) noexcept;

/// The longest duration that can be written.
inline constexpr std::chrono::hours kLongestDuration{1000};

/// @return the duration that `text` spells, with fractions of 1 ns rounded up; nothing for any
///         other text and for more than kLongestDuration.
[[nodiscard]] std::optional<std::chrono::nanoseconds> parse_duration(std::string_view text);

/// @return the shortest text that reads back as the same number.
[[nodiscard]] std::string to_text(double number);

/// @return a text such as "0x607D" with at least `digits` digits, in capitals.
[[nodiscard]] std::string hex(std::uint64_t number, std::size_t digits);

/// @return the number of a session as shown in messages, events, logs and recordings, such as
///         "0x0123456789abcdef".
[[nodiscard]] std::string session_text(std::uint64_t session);

}  // namespace vdrive
