// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::canopen {

/// The largest payload of a classical CAN frame [bytes].
inline constexpr std::size_t kMostData = 8;

inline constexpr std::uint32_t kHighestBaseId = 0x7FF;           ///< 11 bits
inline constexpr std::uint32_t kHighestExtendedId = 0x1FFFFFFF;  ///< 29 bits

/// A data or remote frame of classical CAN (ISO 11898-1). CANopen uses the base format only;
/// extended frames pass over the bus, and no node answers them.
struct Frame {
  std::uint32_t id = 0;      ///< 0 to kHighestBaseId, or to kHighestExtendedId
  bool is_extended = false;  ///< 29-bit identifier
  bool is_remote = false;    ///< requests data (RTR) and carries none
  std::uint8_t size = 0;     ///< bytes of `data`, 0 to 8; in a remote frame, those requested
  std::array<std::uint8_t, kMostData> data{};

  [[nodiscard]] std::span<const std::uint8_t> bytes() const noexcept {
    return {data.data(), is_remote ? std::size_t{0} : std::size_t{size}};
  }

  friend bool operator==(const Frame&, const Frame&) = default;
};

/// Drive time as the bench counts it (in real time: since 1970). A node uses only differences, for
/// its heartbeats, inhibit times and event timers.
using DriveTime = std::chrono::microseconds;

/// Numbers in the byte order of frames: least significant byte first.

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

/// @param bytes 1 to 8, in two's complement
[[nodiscard]] constexpr std::int64_t signed_little_endian_number(
    std::span<const std::uint8_t> bytes) noexcept {
  const auto unused = static_cast<unsigned>(8 * (sizeof(std::int64_t) - bytes.size()));
  // The arithmetic shift back extends the sign.
  return static_cast<std::int64_t>(little_endian_number(bytes) << unused) >> unused;
}

}  // namespace vdrive::canopen
