// SPDX-License-Identifier: Apache-2.0
// The parts of DDS Security that are sent unencrypted (DDS Security 1.1, formal/18-04-01). The
// library uses their lengths and counts before it has authenticated anything. Pure functions of
// bytes.
#pragma once

#include "rtps.hpp"
#include "vdrive/wire/guard.hpp"

#include <cstdint>

namespace vdrive::wire {

/// Checks the order of the submessages of a datagram: an encrypted part is a prefix, a body and a
/// postfix with nothing in between, each of exactly the length that the library reads.
class SecureOrder {
 public:
  /// @return Refusal::none when the submessage is allowed at this point
  [[nodiscard]] Refusal next(const Submessage& submessage) noexcept {
    // Inline: this is the only cost of the check when nothing is encrypted.
    const bool is_clear = expected_ == 0 && !ended_ && !is_secure(submessage.kind);
    return is_clear ? Refusal::none : next_part(submessage);
  }

  /// @return whether the datagram may end here, with no part missing.
  [[nodiscard]] bool may_end() const noexcept { return expected_ == 0; }

 private:
  [[nodiscard]] Refusal next_part(const Submessage& submessage) noexcept;
  [[nodiscard]] Refusal begin(const Submessage& submessage) noexcept;

  std::uint8_t expected_ = 0;  ///< the kind that must follow; 0 = any
  bool of_message_ = false;    ///< the complete message is encrypted, not just a submessage
  bool ended_ = false;         ///< its postfix has been seen: nothing may follow
};

/// @return whether a participant of the closed mode sends the submessage unencrypted: information
///         about other submessages, announcements of participants, the handshake, and the key
///         exchange, which is encrypted with its own keys. In the library, these are the endpoints
///         with supports_rtps_protection(false).
[[nodiscard]] bool may_be_in_clear(const Submessage& submessage) noexcept;

/// @param value of a token parameter
/// @return whether it is a single DataHolder with all counts and lengths inside it.
[[nodiscard]] bool is_token(ByteView value, bool little) noexcept;

/// @return whether the content of the DATA is a single ParticipantGenericMessage with all counts
///         and lengths inside it, including those of the announcement that it contains.
[[nodiscard]] bool is_handshake(const Submessage& submessage, const DataSubmessage& data) noexcept;

}  // namespace vdrive::wire
