// SPDX-License-Identifier: Apache-2.0
// The check of a datagram before the DDS library reads it. A pure function of bytes and mode.
#pragma once

#include "vdrive/wire/guard.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::wire {

/// The widest range of a single GAP, which the library processes number by number.
constexpr std::int64_t kWidestGap = 65'536;

/// The mode of the receiving participant.
enum class Mode : std::uint8_t { open, closed };

/// Result of the check.
struct DatagramReport {
  Refusal refusal = Refusal::none;
  /// Length of the part that the library may read [bytes]: without the statistics that another Fast
  /// DDS participant appends, whose content the library would trust.
  std::size_t length = 0;
  bool announces = false;  ///< has discovery DATA, see Guard::pass_discovery
};

/// Checks the RTPS header, that the submessages fill the datagram, that each is complete and of a
/// known kind, and that its numbers are plausible. In encrypted parts it checks the order and every
/// length, which the library trusts before it decrypts; their content is opaque. In the closed mode
/// little else passes, see may_be_in_clear().
/// @param datagram as received, any bytes
[[nodiscard]] DatagramReport check_datagram(std::span<const std::uint8_t> datagram,
                                            Mode mode = Mode::open) noexcept;

/// @return Refusal::parameters unless the list is terminated and everything that the library reads
///         in it is complete.
[[nodiscard]] Refusal check_list(std::span<const std::uint8_t> bytes, bool little) noexcept;

}  // namespace vdrive::wire
