// SPDX-License-Identifier: Apache-2.0
#include "vdrive/assert.hpp"
#include "vdrive/wire/guard.hpp"

#include <numeric>

namespace vdrive::wire {

std::string_view describe(Refusal refusal) noexcept {
  constexpr std::array<std::string_view, kRefusals> kWords{
      "accepted",
      "no RTPS header of version 2",
      "a submessage that ends outside the datagram or is too short",
      "a submessage of an unknown kind",
      "a submessage 0x80 in the wrong place or of the wrong length",
      "a sequence number out of range",
      "a HEARTBEAT or GAP with an impossible range",
      "a set of more than 256 numbers",
      "a DATA submessage without content",
      "fragments that do not fit their sample",
      "an unterminated parameter list",
      "an announcement without a lease, in pieces or in the name of another participant",
      "more participants than the guard keeps",
      "an encrypted part with wrong lengths or order",
      "a token or handshake message that is fragmented or has a count or length beyond its size",
      "unencrypted content in the closed mode",
      "a sequence number far from those that its writer has sent"};
  const auto kind = static_cast<std::size_t>(refusal);
  ensure(kind < kWords.size(), "each refusal has words");
  return kWords[kind];
}

std::uint64_t GuardCounts::all_refused() const noexcept {
  return std::accumulate(refused.begin(), refused.end(), std::uint64_t{0});
}

}  // namespace vdrive::wire
