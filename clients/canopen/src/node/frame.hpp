// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
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

}  // namespace vdrive::canopen
