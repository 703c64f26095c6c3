// SPDX-License-Identifier: Apache-2.0
#include "vdrive/number_text.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace vdrive {
namespace {

std::string hex_of(std::uint64_t number, std::size_t digits, std::string_view alphabet) {
  std::string text;
  for (; number != 0 || text.size() < digits; number >>= 4U) {
    text.insert(text.begin(), alphabet[number & 0xFU]);
  }
  return "0x" + text;
}

}  // namespace

std::optional<std::int64_t> parse_integer(std::string_view text) {
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    text.remove_prefix(2);
    base = 16;
    if (text.starts_with('-')) return std::nullopt;
  }
  return parse_digits<std::int64_t>(text, base);
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  const bool whole = result.ec == std::errc{} && result.ptr == end && std::isfinite(value);
  return whole ? std::optional(value) : std::nullopt;
}

std::string to_text(double number) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number);
  return {buffer.data(), result.ptr};
}

std::string hex(std::uint64_t number, std::size_t digits) {
  return hex_of(number, digits, "0123456789ABCDEF");
}

std::string session_text(std::uint64_t session) {
  return hex_of(session, 16, "0123456789abcdef");
}

}  // namespace vdrive
