// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::canopen {

/// Bytes that a frame of classical CAN has at most.
inline constexpr std::size_t kMostData = 8;

inline constexpr std::uint32_t kHighestBaseId = 0x7FF;           ///< 11 bits
inline constexpr std::uint32_t kHighestExtendedId = 0x1FFFFFFF;  ///< 29 bits

/// A data or remote frame of classical CAN (ISO 11898-1). CANopen uses the base format only; an
/// extended frame passes through the bus, and no node answers it.
struct Frame {
  std::uint32_t id = 0;      ///< 0 to kHighestBaseId, or to kHighestExtendedId
  bool is_extended = false;  ///< 29-bit identifier
  bool is_remote = false;    ///< asks for data (RTR), and has none
  std::uint8_t size = 0;     ///< bytes of `data`, 0 to 8; of a remote frame: those asked for
  std::array<std::uint8_t, kMostData> data{};

  [[nodiscard]] std::span<const std::uint8_t> bytes() const noexcept {
    return {data.data(), is_remote ? std::size_t{0} : std::size_t{size}};
  }

  friend bool operator==(const Frame&, const Frame&) = default;
};

/// Drive time as the bench counts it (in real time since 1970): only differences have a meaning to
/// a node. Its heartbeats, inhibit times and event timers count it.
using DriveTime = std::chrono::microseconds;

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
