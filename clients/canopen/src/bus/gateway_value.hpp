// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::canopen {

/// Values of objects as text (CiA 309-3, "Data type syntax").

enum class GatewayKind : std::uint8_t {
  boolean,  ///< 0 or 1
  integer,  ///< decimal, or hexadecimal after 0x
  natural,  ///< as integer, without a sign
  real,     ///< such as -1.5e3
  visible,  ///< text; in double quotes, with each inner double quote doubled
  encoded,  ///< bytes in base64 (RFC 2045), on one line
};

struct GatewayType {
  std::string_view name;
  GatewayKind kind{};
  std::uint8_t size = 0;  ///< [bytes]; 0 = any number

  friend bool operator==(const GatewayType&, const GatewayType&) = default;
};

inline constexpr std::array kGatewayTypes{
    GatewayType{"b", GatewayKind::boolean, 1},   GatewayType{"i8", GatewayKind::integer, 1},
    GatewayType{"i16", GatewayKind::integer, 2}, GatewayType{"i32", GatewayKind::integer, 4},
    GatewayType{"i64", GatewayKind::integer, 8}, GatewayType{"u8", GatewayKind::natural, 1},
    GatewayType{"u16", GatewayKind::natural, 2}, GatewayType{"u32", GatewayKind::natural, 4},
    GatewayType{"u64", GatewayKind::natural, 8}, GatewayType{"r32", GatewayKind::real, 4},
    GatewayType{"r64", GatewayKind::real, 8},    GatewayType{"vs", GatewayKind::visible, 0},
    GatewayType{"os", GatewayKind::encoded, 0},  GatewayType{"us", GatewayKind::encoded, 0},
    GatewayType{"d", GatewayKind::encoded, 0},
};

/// @param name in lower case
[[nodiscard]] std::optional<GatewayType> find_gateway_type(std::string_view name);

/// @return the number in `text`, decimal or hexadecimal after 0x, without a sign.
[[nodiscard]] std::optional<std::uint64_t> parse_natural(std::string_view text);

/// @param text without its quotes
/// @return the bytes of the value, least significant first; nothing if `text` is not a value of
///         this type.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> encode_value(const GatewayType& type,
                                                                    std::string_view text);

/// Trailing zeros of a `visible` value are removed; vdrive::escaped() encodes characters that a
/// line cannot contain.
/// @return the text of a value, in quotes if the type has them; nothing if the size of `data` is
///         not that of the type.
[[nodiscard]] std::optional<std::string> decode_value(const GatewayType& type,
                                                      std::span<const std::uint8_t> data);

/// @return the bytes of a value of unknown type, such as "50 02".
[[nodiscard]] std::string hex_bytes(std::span<const std::uint8_t> data);

}  // namespace vdrive::canopen
