// SPDX-License-Identifier: Apache-2.0
// What a datagram must be before the DDS library reads it. A pure function of bytes.
#pragma once

#include "vdrive/wire/guard.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::wire {

/// The widest range of a single GAP. The library takes a step for each number in it.
constexpr std::int64_t kWidestGap = 65'536;

/// What the check has found.
struct DatagramReport {
  Refusal refusal = Refusal::none;
  /// [bytes] of the datagram that the library may read: without the statistics that another
  /// participant of its kind appends, whose content it would trust.
  std::size_t length = 0;
  std::uint32_t gap_numbers = 0;  ///< sequence numbers in all its GAPs
  bool announces = false;         ///< has DATA of discovery, see rewrite_announcements
};

/// Checks the RTPS header, that the submessages fill the datagram, that each is of a known kind and
/// whole, and that its numbers are within reason. What is encrypted is opaque and passes.
/// @param datagram as received, any bytes
[[nodiscard]] DatagramReport check_datagram(std::span<const std::uint8_t> datagram) noexcept;

}  // namespace vdrive::wire
