// SPDX-License-Identifier: Apache-2.0
#include "seam/wire_link.hpp"

#include <chrono>

namespace vdrive::service {

WireLink::WireLink(const WireRegion& region)
    : control_(region.control()),
      status_(region.ring(Lane::status)),
      replies_(region.ring(Lane::replies)),
      reports_(region.ring(Lane::reports)),
      status_bell_(control_.status_bell),
      reports_bell_(control_.reports_bell) {}

void WireLink::begin() noexcept {
  control_.running_generation = 1;
  control_.state = WireState::running;
}

void WireLink::end() noexcept {
  control_.state = WireState::none;
}

ByteRing& WireLink::ring(Lane lane) noexcept {
  return lane == Lane::status ? status_ : lane == Lane::replies ? replies_ : reports_;
}

bool WireLink::post_to(const wire::Source& destination, const msg::Reply& reply,
                       std::span<const wire::ShownAxis> axes) {
  const auto place = replies_.reserve(wire::encoded_reply_size(reply, axes.size()));
  if (!place) return false;
  const auto size = static_cast<std::uint32_t>(wire::encode_reply(reply, axes, *place));
  replies_.commit({.size = size,
                   .full_size = size,
                   .topic = static_cast<std::uint16_t>(wire::Topic<msg::Reply>::kId),
                   .flags = RecordHead::kForOne,
                   .party = destination});
  return true;
}

void WireLink::flush(Lane lane) {
  if (sender_ != nullptr) {
    while (sender_->drain(lane)) {
    }
    return;
  }
  // The engine flushes whether or not it has written; a wire with nothing to send is not woken.
  if (ring(lane).size() == 0) return;
  (lane == Lane::status ? status_bell_ : reports_bell_).ring();
}

std::uint32_t WireLink::matched(wire::TopicId topic) const noexcept {
  return running() == 0
             ? 0
             : control_.matched[static_cast<std::size_t>(topic)].load(std::memory_order_relaxed);
}

bool WireLink::is_gone(const wire::Source& source) const noexcept {
  // A restarted wire knows no readers at first: a missing reader is conclusive only after discovery
  // has had time to find it.
  constexpr std::chrono::seconds kTimeToFind{2};
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  const auto age = now - std::chrono::nanoseconds(control_.running_since.load());
  const bool is_first = control_.generation.load() <= 1;
  return running() != 0 && (is_first || age > kTimeToFind) && !is_matched(source);
}

std::uint32_t WireLink::running() const noexcept {
  return control_.state.load(std::memory_order_acquire) == WireState::running
             ? control_.running_generation.load(std::memory_order_relaxed)
             : 0;
}

}  // namespace vdrive::service
