// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>

namespace vdrive::wire {

/// Why the guard of a participant withholds a datagram from the DDS library.
enum class Refusal : std::uint8_t {
  none,          ///< the datagram passes
  header,        ///< not an RTPS header of version 2
  length,        ///< a submessage ends outside the datagram, or is too short for its kind
  submessage,    ///< a kind that no conforming participant sends
  statistics,    ///< the library's submessage 0x80 in the wrong place or of the wrong length
  sequence,      ///< a sequence number below its minimum or above 2^40
  range,         ///< a HEARTBEAT or GAP whose range is reversed or too wide
  set,           ///< a sequence number set of more than 256 bits
  data,          ///< a DATA with neither data nor key nor status, or with both data and key
  fragment,      ///< fragments that do not fit their sample, or a sample above 16 MB
  parameters,    ///< an unterminated parameter list, or a text longer than its parameter
  announcement,  ///< an announcement without a lease or in the name of another participant
  participants,  ///< more participants than the guard keeps (4,096)
  security,      ///< an encrypted part with a wrong length or order
  handshake,     ///< a fragmented token or handshake message, or a count or length beyond its end
  unprotected,   ///< in the closed mode: unencrypted content that must be encrypted
  jump,          ///< a sequence number far from those that its writer has sent
};

constexpr std::size_t kRefusals = 17;  ///< including `none`

/// @return words for a log, such as "an unterminated parameter list".
[[nodiscard]] std::string_view describe(Refusal refusal) noexcept;

/// A vdrive participant that is silent for this long is removed; it announces itself every 100 ms.
inline constexpr std::chrono::milliseconds kPatienceWithVdrive{2'500};

/// Counts of the guard of a participant, since the participant was created.
struct GuardCounts {
  std::array<std::uint64_t, kRefusals> refused{};  ///< datagrams by Refusal; [none] stays 0
  std::uint64_t handed_over = 0;                   ///< datagrams passed on to the library
  std::uint64_t ignored = 0;  ///< announcements of other clients ignored by a client
  std::uint64_t judged = 0;  ///< participants removed: silent, or gone without the library noticing
  /// Datagrams held back: those with heartbeats of participants that have just returned, and all
  /// from discovery servers that have just returned.
  std::uint64_t held_back = 0;
  std::uint64_t kept = 0;  ///< participants watched now

  /// @return the datagrams that were refused for any reason.
  [[nodiscard]] std::uint64_t all_refused() const noexcept;
};

/// Receives each refusal with the address of the sender, such as "127.0.0.1:7410". Runs in the
/// receive thread: must be short, must not throw, and should log at most one line per second.
using GuardSink = std::function<void(Refusal, std::string_view sender)>;

}  // namespace vdrive::wire
