// SPDX-License-Identifier: Apache-2.0
#include "engine/pending_frames.hpp"

#include "vdrive/assert.hpp"

#include <algorithm>

namespace vdrive::service {

PendingFrames::PendingFrames() : slots_(kCapacity) {
  order_.reserve(kCapacity);
  free_.reserve(kCapacity);
  for (std::size_t slot = kCapacity; slot > 0; --slot) {
    free_.push_back(static_cast<std::uint16_t>(slot - 1));
  }
}

bool PendingFrames::insert(std::uint64_t tick, msg::CommandFrame& frame) noexcept {
  if (free_.empty()) return false;
  const std::uint16_t slot = free_.back();
  free_.pop_back();
  exchange(slots_.reach(slot), frame);
  const auto place = std::ranges::upper_bound(order_, tick, {}, &Place::tick);
  order_.insert(place, {tick, slot});
  return true;
}

bool PendingFrames::take_due(std::uint64_t tick, msg::CommandFrame& frame) noexcept {
  if (order_.empty() || order_.front().tick > tick) return false;
  exchange(slots_[order_.front().slot], frame);
  remove(0);
  return true;
}

bool PendingFrames::contains(std::uint64_t session, std::uint64_t sequence) const noexcept {
  return std::ranges::any_of(order_, [&](const Place& place) {
    const auto& frame = slots_[place.slot].head;
    return frame.session == session && frame.sequence_number == sequence;
  });
}

/// Swaps the heads and the commands, but not the lists of commands: each keeps its own capacity.
void PendingFrames::exchange(Slot& slot, msg::CommandFrame& frame) {
  std::swap(slot.head, frame);
  std::swap(slot.head.axes, frame.axes);
  slot.commands.exchange(frame.axes);
}

void PendingFrames::remove(std::size_t position) noexcept {
  ensure(position < order_.size() && free_.size() < kCapacity, "a frame leaves its slot once");
  free_.push_back(order_[position].slot);
  order_.erase(order_.begin() + static_cast<std::ptrdiff_t>(position));
}

}  // namespace vdrive::service
