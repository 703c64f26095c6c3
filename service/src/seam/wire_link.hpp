// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "seam/lane_sender.hpp"
#include "seam/wire_region.hpp"
#include "vdrive/wire/codec.hpp"
#include "vdrive/wire/reply.hpp"
#include "vdrive/wire/topics.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

namespace vdrive::service {

/// The engine's end of the seam: encodes outgoing messages into the lanes and has them sent. A lane
/// belongs to one thread.
class WireLink {
 public:
  /// @param region outlives this
  explicit WireLink(const WireRegion& region);

  /// From now on `flush` sends in the calling thread, because the wire is part of this process.
  /// @param sender outlives this
  void send_through(LaneSender& sender) noexcept { sender_ = &sender; }

  /// Marks the wire of this process as running or ended. A wire in its own process does that
  /// itself.
  void begin() noexcept;
  void end() noexcept;

  /// Encodes a message into a lane. @return false if there is no room.
  template <typename Message>
  [[nodiscard]] bool post(Lane lane, const Message& message) {
    return post(
        lane, message,
        RecordHead{.topic = static_cast<std::uint16_t>(wire::Topic<Message>::kId), .party = {}});
  }

  /// The same for an answer, which waits until `destination` can be reached.
  /// @param axes the statuses to send instead of those in `reply`
  [[nodiscard]] bool post_to(const wire::Source& destination, const msg::Reply& reply,
                             std::span<const wire::ShownAxis> axes = {});

  /// @return the producer's end of an outgoing lane, for messages that are encoded in place.
  [[nodiscard]] ByteRing& ring(Lane lane) noexcept;

  /// Has the waiting records of the lane sent: now, by this thread, or soon, by the wire's process.
  void flush(Lane lane);

  /// @return the number of subscriptions that match a topic; 0 while no wire runs.
  [[nodiscard]] std::uint32_t matched(wire::TopicId topic) const noexcept;

  /// @return whether the wire has requested a bench_state for a new reader since the last call.
  [[nodiscard]] bool take_state_request() noexcept {
    return control_.is_state_requested.load(std::memory_order_relaxed) &&
           control_.is_state_requested.exchange(false);
  }

  /// @return whether the participant is currently a reader of replies.
  [[nodiscard]] bool is_matched(const wire::Source& source) const noexcept {
    return control_.readers.may_contain(source);
  }

  /// @return whether a participant that used to read replies is gone. All participants have 2 s to
  ///         discover a restarted wire.
  [[nodiscard]] bool is_gone(const wire::Source& source) const noexcept;

  /// @return the number of the running wire; 0 = no wire runs.
  [[nodiscard]] std::uint32_t running() const noexcept;

  /// @return whether this process has to flush again soon, because an answer waits for its reader.
  [[nodiscard]] bool is_holding() const noexcept {
    return sender_ != nullptr && sender_->is_holding();
  }

  [[nodiscard]] WireControl& control() const noexcept { return control_; }

 private:
  template <typename Message>
  bool post(Lane lane, const Message& message, RecordHead head) {
    const std::size_t size = wire::encoded_size(message);
    const auto place = ring(lane).reserve(size);
    if (!place) return false;
    head.size = static_cast<std::uint32_t>(wire::encode(message, *place));
    head.full_size = head.size;
    ring(lane).commit(head);
    return true;
  }

  WireControl& control_;
  ByteRing status_;
  ByteRing replies_;
  ByteRing reports_;
  Doorbell status_bell_;
  Doorbell reports_bell_;
  LaneSender* sender_ = nullptr;
};

}  // namespace vdrive::service
