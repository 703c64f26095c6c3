// SPDX-License-Identifier: Apache-2.0
#include "bus/gateway_value.hpp"

#include "node/frame.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>

namespace vdrive::canopen {
namespace {

using ValueBytes = std::vector<std::uint8_t>;

constexpr std::string_view kBase64 =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::size_t kGroupText = 4;   // characters of base64 in a group
constexpr std::size_t kGroupBytes = 3;  // bytes
constexpr std::uint32_t kSextet = 0x3F;

ValueBytes little_endian_bytes(std::uint64_t number, std::size_t size) {
  ValueBytes bytes(size);
  put_little_endian(number, bytes);
  return bytes;
}

/// @return the highest number with `bits` bits, 1 to 64.
constexpr std::uint64_t highest_of(unsigned bits) {
  return std::numeric_limits<std::uint64_t>::max() >> (64U - bits);
}

std::optional<ValueBytes> encode_natural(std::string_view text, std::size_t size,
                                         std::uint64_t highest) {
  const auto number = parse_natural(text);
  if (!number || *number > highest) return std::nullopt;
  return little_endian_bytes(*number, size);
}

std::optional<ValueBytes> encode_integer(std::string_view text, std::size_t size) {
  const bool is_negative = text.starts_with('-');
  const auto number = parse_natural(is_negative ? text.substr(1) : text);
  const std::uint64_t highest = highest_of(static_cast<unsigned>(size) * 8U - 1U);
  if (!number || *number > highest + (is_negative ? 1U : 0U)) return std::nullopt;
  // Two's complement: its lower bytes are right for every size.
  return little_endian_bytes(is_negative ? std::uint64_t{0} - *number : *number, size);
}

std::optional<ValueBytes> encode_real(std::string_view text, std::size_t size) {
  const auto number = parse_number(text);
  if (!number) return std::nullopt;
  if (size == sizeof(double))
    return little_endian_bytes(std::bit_cast<std::uint64_t>(*number), size);
  if (std::abs(*number) > static_cast<double>(std::numeric_limits<float>::max()))
    return std::nullopt;
  return little_endian_bytes(std::bit_cast<std::uint32_t>(static_cast<float>(*number)), size);
}

/// @return the shortest text that parses to the same number, also "inf" and "nan".
template <typename Real>
std::string real_text(Real number) {
  std::array<char, 32> text{};
  const auto written = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), written.ptr};
}

std::string decode_real(std::span<const std::uint8_t> data) {
  const std::uint64_t bits = little_endian_number(data);
  if (data.size() == sizeof(double)) return real_text(std::bit_cast<double>(bits));
  return real_text(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
}

std::string decode_visible(std::span<const std::uint8_t> data) {
  std::string text(data.begin(), data.end());
  // Some nodes pad their strings.
  text.erase(text.find_last_not_of('\0') + 1);
  std::string out(1, '"');
  for (const char c : escaped(text, text.size())) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

std::string encode_base64(std::span<const std::uint8_t> data) {
  std::string text;
  while (!data.empty()) {
    const std::size_t count = std::min(kGroupBytes, data.size());
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < kGroupBytes; ++i) {
      group = group << 8U | (i < count ? std::uint32_t{data[i]} : 0U);
    }
    for (std::size_t i = 0; i < kGroupText; ++i) {
      const auto shift = static_cast<unsigned>(6 * (kGroupText - 1 - i));
      text += i <= count ? kBase64[group >> shift & kSextet] : '=';
    }
    data = data.subspan(count);
  }
  return text;
}

/// Appends the bytes of four characters.
/// @return whether they are valid base64; `=` is allowed only in the last group.
bool append_base64_group(ValueBytes& bytes, std::string_view group, bool is_last) {
  const std::size_t padding = is_last ? group.size() - 1 - group.find_last_not_of('=') : 0;
  if (padding > 2) return false;
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < kGroupText; ++i) {
    const std::size_t digit = i + padding < kGroupText ? kBase64.find(group[i]) : 0;
    if (digit == std::string_view::npos) return false;
    number = number << 6U | static_cast<std::uint32_t>(digit);
  }
  for (std::size_t i = 0; i + padding < kGroupBytes; ++i) {
    bytes.push_back(static_cast<std::uint8_t>(number >> (8U * (kGroupBytes - 1 - i))));
  }
  return true;
}

std::optional<ValueBytes> decode_base64(std::string_view text) {
  if (text.size() % kGroupText != 0) return std::nullopt;
  ValueBytes bytes;
  bytes.reserve(text.size() / kGroupText * kGroupBytes);
  while (!text.empty()) {
    if (!append_base64_group(bytes, text.substr(0, kGroupText), text.size() == kGroupText)) {
      return std::nullopt;
    }
    text.remove_prefix(kGroupText);
  }
  return bytes;
}

}  // namespace

std::optional<GatewayType> find_gateway_type(std::string_view name) {
  const auto found = std::ranges::find(kGatewayTypes, name, &GatewayType::name);
  return found == kGatewayTypes.end() ? std::nullopt : std::optional(*found);
}

std::optional<std::uint64_t> parse_natural(std::string_view text) {
  return has_hex_prefix(text) ? parse_digits<std::uint64_t>(text.substr(2), 16)
                              : parse_digits<std::uint64_t>(text);
}

std::optional<std::vector<std::uint8_t>> encode_value(const GatewayType& type,
                                                      std::string_view text) {
  switch (type.kind) {
    case GatewayKind::boolean:
      return encode_natural(text, type.size, 1);
    case GatewayKind::integer:
      return encode_integer(text, type.size);
    case GatewayKind::natural:
      return encode_natural(text, type.size, highest_of(type.size * 8U));
    case GatewayKind::real:
      return encode_real(text, type.size);
    case GatewayKind::visible:
      return ValueBytes(text.begin(), text.end());
    case GatewayKind::encoded:
      return decode_base64(text);
  }
  return std::nullopt;
}

std::optional<std::string> decode_value(const GatewayType& type,
                                        std::span<const std::uint8_t> data) {
  if (type.size != 0 && data.size() != type.size) return std::nullopt;
  switch (type.kind) {
    case GatewayKind::boolean:
    case GatewayKind::natural:
      return std::to_string(little_endian_number(data));
    case GatewayKind::integer:
      return std::to_string(signed_little_endian_number(data));
    case GatewayKind::real:
      return decode_real(data);
    case GatewayKind::visible:
      return decode_visible(data);
    case GatewayKind::encoded:
      return encode_base64(data);
  }
  return std::nullopt;
}

std::string hex_bytes(std::span<const std::uint8_t> data) {
  std::string text;
  for (const std::uint8_t byte : data) {
    if (!text.empty()) text += ' ';
    text += hex(byte, 2).substr(2);
  }
  return text;
}

}  // namespace vdrive::canopen
