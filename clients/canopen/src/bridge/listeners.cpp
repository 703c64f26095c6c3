// SPDX-License-Identifier: Apache-2.0
#include "bridge/listeners.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>

namespace vdrive::canopen {
namespace {

/// A range of the predefined connection set (CiA 301, 7.3.5) whose frames only reach nodes that
/// list their identifier.
struct IdentifierRange {
  std::uint16_t first = 0;
  std::uint16_t last = 0;
};

constexpr std::array kNamed{IdentifierRange{0x081, 0x0FF},   // EMCY
                            IdentifierRange{0x180, 0x57F},   // PDOs
                            IdentifierRange{0x580, 0x67F},   // SDO
                            IdentifierRange{0x700, 0x77F}};  // heartbeats

constexpr std::uint16_t kSdoRequestIds = 0x600;

}  // namespace

void Listeners::clear() {
  whom_.fill(kEverybody);
  for (const IdentifierRange& range : kNamed) {
    std::fill(whom_.begin() + range.first, whom_.begin() + range.last + 1, kNobody);
  }
}

void Listeners::add(std::size_t place, const Listener& listener) {
  ensure(place < kMostPlaces, "a bus has 127 nodes at most");
  const auto own = static_cast<std::uint8_t>(place);
  const auto listen = [&](std::uint16_t identifier) {
    std::uint8_t& whom = whom_.at(identifier);
    if (whom != own) whom = whom == kNobody ? own : kEverybody;
  };
  listen(static_cast<std::uint16_t>(kSdoRequestIds + listener.id));
  for (const std::uint16_t identifier : listener.identifiers) listen(identifier);
}

Listeners::Answer Listeners::find(const Frame& frame) const noexcept {
  if (frame.is_extended || frame.id > kHighestBaseId) return {.kind = Kind::nobody};
  // Remote frames request a frame that a node sends; those identifiers are not listed.
  if (frame.is_remote) return {.kind = Kind::everybody};
  const std::uint8_t whom = whom_[frame.id];
  if (whom == kNobody) return {.kind = Kind::nobody};
  if (whom == kEverybody) return {.kind = Kind::everybody};
  return {.kind = Kind::one, .place = whom};
}

}  // namespace vdrive::canopen
