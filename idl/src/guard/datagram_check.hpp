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

/// The mode of the participant that receives.
enum class Mode : std::uint8_t { open, closed };

/// What the check has found.
struct DatagramReport {
  Refusal refusal = Refusal::none;
  /// [bytes] of the datagram that the library may read: without the statistics that another
  /// participant of its kind appends, whose content it would trust.
  std::size_t length = 0;
  bool announces = false;  ///< has DATA of discovery, see rewrite_announcements
};

/// Checks the RTPS header, that the submessages fill the datagram, that each is of a known kind and
/// whole, and that its numbers are within reason. Of what is encrypted it checks the order and
/// every length, which the library believes before it decrypts; the content is opaque. In the
/// closed mode little else passes, see may_be_in_clear().
/// @param datagram as received, any bytes
[[nodiscard]] DatagramReport check_datagram(std::span<const std::uint8_t> datagram,
                                            Mode mode = Mode::open) noexcept;

/// @return Refusal::parameters unless the list ends and what the library reads in it is whole.
[[nodiscard]] Refusal check_list(std::span<const std::uint8_t> bytes, bool little) noexcept;

}  // namespace vdrive::wire
