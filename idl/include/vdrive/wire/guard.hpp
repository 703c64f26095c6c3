// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>

namespace vdrive::wire {

/// Why the guard of a participant keeps a datagram from the DDS library.
enum class Refusal : std::uint8_t {
  none,          ///< it passes
  header,        ///< no RTPS header of version 2
  length,        ///< a submessage ends outside of the datagram, or is shorter than its kind
  submessage,    ///< a kind that no conforming participant sends
  statistics,    ///< the library's own 0x80 in the wrong place or of the wrong length
  sequence,      ///< a sequence number below its least or above 2^40
  range,         ///< a HEARTBEAT or GAP whose range is reversed or too wide
  set,           ///< a set of numbers with more than 256 bits
  data,          ///< a DATA without data, key and status, or with both data and key
  fragment,      ///< fragments that do not fit their sample, or a sample above 16 MB
  parameters,    ///< a list of parameters that does not end, or a text that is longer than its
                 ///< parameter
  announcement,  ///< a participant's announcement without a lease or in another one's name
  participants,  ///< more participants than the guard keeps, 4,096
  security,      ///< an encrypted part with another length or order than it must have
  handshake,     ///< a token, or a message of the handshake, whose counts or lengths exceed it, or
                 ///< such a message in pieces
  unprotected,   ///< in the closed mode: unencrypted, and nothing that is allowed to be
  jump,          ///< a sequence number far from all that its writer has sent
};

constexpr std::size_t kRefusals = 17;  ///< with `none`

/// @return words for a log, such as "a list of parameters that does not end".
[[nodiscard]] std::string_view describe(Refusal refusal) noexcept;

/// A participant of vdrive is removed after this silence: it announces itself ten times a second.
inline constexpr std::chrono::milliseconds kPatienceWithVdrive{2'500};

/// What the guard of a participant has done since the participant was made.
struct GuardCounts {
  std::array<std::uint64_t, kRefusals> refused{};  ///< datagrams by Refusal; [none] stays 0
  std::uint64_t handed_over = 0;                   ///< datagrams that the library got
  std::uint64_t ignored = 0;  ///< announcements of clients that a client ignored
  std::uint64_t judged = 0;   ///< removed: silent, or left unnoticed by the library
  /// With heartbeats of participants that have just come back; all of discovery servers that have.
  std::uint64_t held_back = 0;
  std::uint64_t kept = 0;  ///< participants that are watched now

  /// @return the datagrams that were refused for any reason.
  [[nodiscard]] std::uint64_t all_refused() const noexcept;
};

/// Receives each refusal with the sender's address, such as "127.0.0.1:7410". Runs in the receiving
/// thread: must be short, must not throw, and should log at most one line a second.
using GuardSink = std::function<void(Refusal, std::string_view sender)>;

}  // namespace vdrive::wire
