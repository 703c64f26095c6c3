// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::canopen {

/// Numbers as frames have them: the least significant byte first.

/// Fills `bytes` with the lowest bytes of `number`.
constexpr void put_little_endian(std::uint64_t number, std::span<std::uint8_t> bytes) noexcept {
  for (std::uint8_t& byte : bytes) {
    byte = static_cast<std::uint8_t>(number & 0xFFU);
    number >>= 8U;
  }
}

/// @param bytes at most 8
[[nodiscard]] constexpr std::uint64_t little_endian_number(
    std::span<const std::uint8_t> bytes) noexcept {
  std::uint64_t number = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) number = number << 8U | bytes[i];
  return number;
}

/// @param bytes 1 to 8, of a two's complement
[[nodiscard]] constexpr std::int64_t signed_little_endian_number(
    std::span<const std::uint8_t> bytes) noexcept {
  const auto unused = static_cast<unsigned>(8 * (sizeof(std::int64_t) - bytes.size()));
  // The shift back repeats the sign.
  return static_cast<std::int64_t>(little_endian_number(bytes) << unused) >> unused;
}

}  // namespace vdrive::canopen
