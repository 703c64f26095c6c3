// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace vdrive {

/// @return the number whose digits are the whole of `text`, or nothing.
/// @param base 10 or 16, without a prefix
template <std::integral Number>
[[nodiscard]] std::optional<Number> parse_digits(std::string_view text, int base = 10) noexcept {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number, base);
  return error == std::errc{} && stop == end ? std::optional(number) : std::nullopt;
}

/// @return the whole number that `text` spells, decimal or 0x..., or nothing.
[[nodiscard]] std::optional<std::int64_t> parse_integer(std::string_view text);

/// @return the finite number that `text` spells, or nothing.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// @return the shortest text that reads back to the same number.
[[nodiscard]] std::string to_text(double number);

/// @return such as "0x607D": at least `digits` digits, in capitals.
[[nodiscard]] std::string hex(std::uint64_t number, std::size_t digits);

/// @return the number of a session as it is shown everywhere: in messages, events, logs and
/// recordings. Such as "0x0123456789abcdef".
[[nodiscard]] std::string session_text(std::uint64_t session);

}  // namespace vdrive
