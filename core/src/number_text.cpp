// SPDX-License-Identifier: Apache-2.0
#include "vdrive/number_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace vdrive {
namespace {

constexpr int kHexBase = 16;

/// With an exponent this large, no number is a 64-bit integer, however long its text.
constexpr std::int64_t kLargestExponent = std::int64_t{1} << 40U;

bool is_digit(char c) noexcept {
  return c >= '0' && c <= '9';
}

std::size_t count_digits(std::string_view text) noexcept {
  const auto* const end = std::ranges::find_if_not(text, is_digit);
  return static_cast<std::size_t>(end - text.begin());
}

/// @return the length of "12", "12.", "12.5" or ".5" at the beginning of `text`; 0 = none.
std::size_t digits_length(std::string_view text) noexcept {
  const std::size_t whole = count_digits(text);
  if (whole == text.size() || text[whole] != '.') return whole;
  const std::size_t fraction = count_digits(text.substr(whole + 1));
  return whole + fraction == 0 ? 0 : whole + 1 + fraction;
}

/// @return the length of "e6", "E-3" or "e+2" at the beginning of `text`; 0 = none.
std::size_t exponent_length(std::string_view text) noexcept {
  if (!text.starts_with('e') && !text.starts_with('E')) return 0;
  const std::size_t sign = text.size() > 1 && (text[1] == '-' || text[1] == '+') ? 1 : 0;
  const std::size_t digits = count_digits(text.substr(1 + sign));
  return digits == 0 ? 0 : 1 + sign + digits;
}

/// A decimal number without rounding: digits * 10^exponent.
struct Decimal {
  bool is_negative = false;
  std::string digits;  ///< without leading or trailing zeros; empty = 0
  std::int64_t exponent = 0;
};

std::int64_t exponent_of(std::string_view text) noexcept {
  if (text.empty()) return 0;
  text.remove_prefix(text.starts_with('+') ? 1 : 0);
  const bool is_negative = text.starts_with('-');
  const auto value = parse_digits<std::int64_t>(text);
  if (!value) return is_negative ? -kLargestExponent : kLargestExponent;
  return std::clamp(*value, -kLargestExponent, kLargestExponent);
}

/// @param text one decimal number and nothing else
Decimal decimal_of(std::string_view text) {
  Decimal number;
  number.is_negative = text.starts_with('-');
  text.remove_prefix(number.is_negative ? 1 : 0);
  const std::size_t length = digits_length(text);
  const std::string_view digits = text.substr(0, length);
  const std::size_t point = std::min(digits.find('.'), length);
  number.digits = digits.substr(0, point);
  if (point < length) number.digits += digits.substr(point + 1);
  const std::size_t decimals = length - std::min(length, point + 1);
  const std::string_view exponent = text.substr(length);
  number.exponent = exponent_of(exponent.empty() ? exponent : exponent.substr(1)) -
                    static_cast<std::int64_t>(decimals);
  const std::size_t last = number.digits.find_last_not_of('0');
  if (last == std::string::npos) return {.is_negative = number.is_negative, .digits = {}};
  number.exponent += static_cast<std::int64_t>(number.digits.size() - 1 - last);
  number.digits.resize(last + 1);
  number.digits.erase(0, number.digits.find_first_not_of('0'));
  return number;
}

/// @return the digits of the product of the number `digits` and `factor`.
std::string times(std::string_view digits, unsigned factor) {
  constexpr unsigned kTen = 10;
  std::string product;
  unsigned carry = 0;
  for (auto digit = digits.rbegin(); digit != digits.rend() || carry != 0;) {
    if (digit != digits.rend()) carry += static_cast<unsigned>(*digit++ - '0') * factor;
    product += static_cast<char>('0' + carry % kTen);
    carry /= kTen;
  }
  std::ranges::reverse(product);
  return product;
}

/// The absolute value of a decimal number, split at the decimal point.
struct SplitDecimal {
  std::optional<std::uint64_t> whole;  ///< nothing if it does not fit in 64 bits
  bool has_fraction = false;
};

SplitDecimal parted(const Decimal& number) {
  const auto count = static_cast<std::int64_t>(number.digits.size());
  const std::int64_t places = count + number.exponent;  // before the point
  if (number.digits.empty()) return {.whole = 0};
  if (places > std::numeric_limits<std::uint64_t>::digits10 + 1) {
    return {.whole = std::nullopt, .has_fraction = number.exponent < 0};
  }
  if (places <= 0) return {.whole = 0, .has_fraction = true};
  std::string whole = number.digits;
  whole.resize(static_cast<std::size_t>(places), '0');
  return {.whole = parse_digits<std::uint64_t>(whole), .has_fraction = number.exponent < 0};
}

IntegerReading read_hex(std::string_view digits) {
  const auto value = parse_digits<std::uint64_t>(digits, kHexBase);
  if (value && *value <= std::uint64_t{std::numeric_limits<std::int64_t>::max()}) {
    return {.kind = IntegerKind::whole, .value = static_cast<std::int64_t>(*value)};
  }
  const bool is_number = !digits.empty() && digits.find_first_not_of("0123456789abcdefABCDEF") ==
                                                std::string_view::npos;
  return {.kind = is_number ? IntegerKind::too_large : IntegerKind::no_number};
}

/// A unit of duration: nanoseconds = factor * 10^exponent.
struct TimeUnit {
  std::string_view name;
  unsigned factor;
  std::int64_t exponent;
};

constexpr std::array kTimeUnits{TimeUnit{"", 1, 9},     TimeUnit{"us", 1, 3},
                                TimeUnit{"ms", 1, 6},   TimeUnit{"s", 1, 9},
                                TimeUnit{"min", 60, 9}, TimeUnit{"h", 3600, 9}};

std::string hex_of(std::uint64_t number, std::size_t digits, std::string_view alphabet) {
  std::string text;
  for (; number != 0 || text.size() < digits; number >>= 4U) {
    text.insert(text.begin(), alphabet[number & 0xFU]);
  }
  return "0x" + text;
}

}  // namespace

bool has_hex_prefix(std::string_view text) noexcept {
  return text.starts_with("0x") || text.starts_with("0X");
}

std::size_t decimal_length(std::string_view text) noexcept {
  const std::size_t sign = text.starts_with('-') ? 1 : 0;
  const std::size_t digits = digits_length(text.substr(sign));
  if (digits == 0) return 0;
  return sign + digits + exponent_length(text.substr(sign + digits));
}

IntegerReading read_integer(std::string_view text) {
  if (has_hex_prefix(text)) return read_hex(text.substr(2));
  if (text.empty() || decimal_length(text) != text.size()) return {};
  const Decimal number = decimal_of(text);
  const SplitDecimal parts = parted(number);
  if (parts.has_fraction) return {.kind = IntegerKind::fraction};
  constexpr std::uint64_t kLargest{std::numeric_limits<std::int64_t>::max()};
  if (!parts.whole || *parts.whole > kLargest + (number.is_negative ? 1 : 0)) {
    return {.kind = IntegerKind::too_large};
  }
  // Negated as unsigned: the lowest number has no positive counterpart.
  return {.kind = IntegerKind::whole,
          .value = static_cast<std::int64_t>(number.is_negative ? 0 - *parts.whole : *parts.whole)};
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
  const IntegerReading reading = read_integer(text);
  return reading.kind == IntegerKind::whole ? std::optional(reading.value) : std::nullopt;
}

std::optional<double> parse_number(std::string_view text) {
  if (has_hex_prefix(text)) {
    const auto bits = parse_digits<std::uint64_t>(text.substr(2), kHexBase);
    return bits ? std::optional(static_cast<double>(*bits)) : std::nullopt;
  }
  // from_chars would accept "inf" and "nan" as well.
  if (decimal_length(text) != text.size()) return std::nullopt;
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  const bool whole = result.ec == std::errc{} && result.ptr == end && std::isfinite(value);
  return whole ? std::optional(value) : std::nullopt;
}

std::optional<std::chrono::nanoseconds> parse_duration(std::string_view text) {
  const std::size_t length = text.starts_with('-') ? 0 : decimal_length(text);
  if (length == 0) return std::nullopt;
  std::string_view name = text.substr(length);
  const bool has_blanks = name.starts_with(' ');
  name.remove_prefix(std::min(name.find_first_not_of(' '), name.size()));
  const auto* const unit = std::ranges::find(kTimeUnits, name, &TimeUnit::name);
  if (unit == kTimeUnits.end() || (name.empty() && has_blanks)) return std::nullopt;
  Decimal number = decimal_of(text.substr(0, length));
  if (!number.digits.empty()) {
    number.digits = times(number.digits, unit->factor);
    number.exponent += unit->exponent;
    // The factor may append zeros: 0.5 min is 30 s.
    const std::size_t last = number.digits.find_last_not_of('0');
    number.exponent += static_cast<std::int64_t>(number.digits.size() - 1 - last);
    number.digits.resize(last + 1);
  }
  const SplitDecimal parts = parted(number);
  constexpr std::uint64_t kMost{std::chrono::nanoseconds(kLongestDuration).count()};
  if (!parts.whole || *parts.whole > kMost) return std::nullopt;
  if (*parts.whole == kMost && parts.has_fraction) return std::nullopt;
  return std::chrono::nanoseconds(*parts.whole + (parts.has_fraction ? 1 : 0));
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
