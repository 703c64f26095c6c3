// SPDX-License-Identifier: Apache-2.0
// What DDS Security sends in clear (DDS Security 1.1, formal/18-04-01): the library computes with
// these lengths and counts before it has authenticated anything. Pure functions of bytes.
#pragma once

#include "rtps.hpp"
#include "vdrive/wire/guard.hpp"

#include <cstdint>

namespace vdrive::wire {

/// Follows the submessages of a datagram: what is encrypted is a prefix, a body and a postfix, with
/// nothing between them, and each has exactly the length that the library reads of it.
class SecureOrder {
 public:
  /// @return Refusal::none when the submessage may stand here
  [[nodiscard]] Refusal next(const Submessage& submessage) noexcept {
    // In line: this is all that the check costs where nothing is encrypted.
    const bool is_clear = expected_ == 0 && !ended_ && !is_secure(submessage.kind);
    return is_clear ? Refusal::none : next_part(submessage);
  }

  /// @return whether nothing is missing at the end of the datagram.
  [[nodiscard]] bool may_end() const noexcept { return expected_ == 0; }

 private:
  [[nodiscard]] Refusal next_part(const Submessage& submessage) noexcept;
  [[nodiscard]] Refusal begin(const Submessage& submessage) noexcept;

  std::uint8_t expected_ = 0;  ///< the kind that must follow; 0 = any
  bool of_message_ = false;    ///< the whole message is encrypted, not one submessage
  bool ended_ = false;         ///< its postfix was there: nothing may follow
};

/// @return whether a participant of the closed mode sends the submessage unencrypted: what informs
///         about others, announcements of participants, the handshake, and the exchange of keys,
///         which is encrypted with keys of its own. The library's own list is the endpoints with
///         supports_rtps_protection(false).
[[nodiscard]] bool may_be_in_clear(const Submessage& submessage) noexcept;

/// @param value of a parameter that is a token
/// @return whether it is one DataHolder, all of whose counts and lengths lie inside it.
[[nodiscard]] bool is_token(ByteView value, bool little) noexcept;

/// @return whether the content of the DATA is one ParticipantGenericMessage, all of whose counts
///         and lengths lie inside it, those of the announcement in it as well.
[[nodiscard]] bool is_handshake(const Submessage& submessage, const DataSubmessage& data) noexcept;

}  // namespace vdrive::wire
