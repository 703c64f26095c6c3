// SPDX-License-Identifier: Apache-2.0
#include "seam/queues.hpp"

#include <algorithm>

namespace vdrive::service {
namespace {

/// The maximum number of samples that one call of Inbox::front() drops.
constexpr std::size_t kMostDropped = 64;

/// Spare commands for the decoder: when a frame has to wait for its tick, its commands move out
/// with the capacity of their objects, and spare ones take their place.
constexpr std::size_t kSpareCommands = 1'024;

/// [bytes] kept of a sample that did not fit: enough for all members of `TurnedAway`.
constexpr std::size_t kBeginning = 64;

}  // namespace

bool InboxWriter::put(wire::TopicId topic, std::span<const std::byte> sample,
                      const wire::Source& source) noexcept {
  const auto room = arrivals_.size() < kCapacity ? arrivals_.reserve(sample.size()) : std::nullopt;
  const bool fits = room.has_value();
  const std::size_t size = fits ? sample.size() : std::min(sample.size(), kBeginning);
  ByteRing& ring = fits ? arrivals_ : turned_away_;
  if (const auto place = fits ? room : ring.reserve(size)) {
    std::ranges::copy(sample.first(size), place->begin());
    ring.commit({.size = static_cast<std::uint32_t>(size),
                 .full_size = static_cast<std::uint32_t>(sample.size()),
                 .topic = static_cast<std::uint16_t>(topic),
                 .flags = 0,
                 .party = source});
  }
  return fits;
}

Inbox::Inbox(std::uint32_t bench, ByteRing arrivals, ByteRing turned_away, Counters& counters)
    : bench_(bench),
      counters_(counters),
      arrivals_(arrivals),
      turned_away_(turned_away),
      decoder_(kSpareCommands) {
  arrival_.frame.axes.reserve(msg::MAX_AXES_PER_FRAME);
  arrival_.request.axes.reserve(msg::MAX_AXES_PER_FRAME);
  arrival_.request.objects.reserve(msg::MAX_OBJECTS_PER_REQUEST);
}

Arrival* Inbox::front() {
  // Dropping malformed samples takes time, too: after kMostDropped, the rest waits for the next
  // call.
  for (std::size_t count = 0; !is_decoded_; ++count) {
    if (count == kMostDropped) return nullptr;
    const auto record = arrivals_.front();
    if (!record) return nullptr;
    is_decoded_ = decode(*record);
    if (!is_decoded_) arrivals_.pop();
  }
  return &arrival_;
}

void Inbox::pop() noexcept {
  is_decoded_ = false;
  arrivals_.pop();
}

bool Inbox::decode(const ByteRing::Record& record) {
  const auto topic = wire::topic_numbered(record.head.topic);
  const bool is_frame = topic == wire::Topic<msg::CommandFrame>::kId;
  if (!is_frame && topic != wire::Topic<msg::Request>::kId) {
    counters_.malformed.add();
    return false;
  }
  const wire::Decoding decoding = is_frame ? decoder_.decode(record.bytes, arrival_.frame)
                                           : decoder_.decode(record.bytes, arrival_.request);
  if (decoding == wire::Decoding::malformed) {
    counters_.malformed.add();
    return false;
  }
  arrival_.kind = is_frame ? Arrival::Kind::command_frame : Arrival::Kind::request;
  arrival_.refusal = decoder_.too_long();
  arrival_.source = record.head.party;
  return (is_frame ? arrival_.frame.bench : arrival_.request.bench) == bench_;
}

std::optional<TurnedAway> Inbox::next_turned_away() {
  const auto record = turned_away_.front();
  if (!record) return std::nullopt;
  // The rest of the message is missing, so the decoder reports it as malformed; its head is valid.
  TurnedAway away{.source = record->head.party};
  if (record->head.topic == static_cast<std::uint16_t>(wire::Topic<msg::CommandFrame>::kId)) {
    msg::CommandFrame frame;
    static_cast<void>(head_decoder_.decode(record->bytes, frame));
    away.session = frame.session;
    away.sequence_number = frame.sequence_number;
  } else {
    msg::Request request;
    static_cast<void>(head_decoder_.decode(record->bytes, request));
    away.kind = Arrival::Kind::request;
    away.client = request.client;
    away.request_id = request.request_id;
    away.session = request.session;
  }
  turned_away_.pop();
  return away;
}

Outbox::Outbox(std::size_t axes, std::size_t images)
    : command_replies(kCommandReplies),
      replies(kReplies),
      events(kEvents),
      parameters(kParameters),
      status(images) {
  replies.for_each_slot([](OutgoingReply& outgoing) {
    outgoing.reply.objects.reserve(msg::MAX_OBJECTS_PER_REQUEST);
  });
  status.for_each_slot([axes](StatusImage& image) {
    image.status.resize(axes);
    image.owners.resize(axes);
  });
}

std::size_t Outbox::size() const noexcept {
  return command_replies.size() + replies.size() + events.size() + parameters.size() +
         status.size();
}

bool Outbox::has_news() const noexcept {
  return command_replies.size() > 0 || replies.size() > 0 || events.size() > 0 ||
         parameters.size() > 0;
}

}  // namespace vdrive::service
