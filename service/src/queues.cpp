// SPDX-License-Identifier: Apache-2.0
#include "vdrive/service/queues.hpp"

#include <algorithm>

namespace vdrive::service {
namespace {

constexpr std::size_t kTurnedAway = 256;
constexpr std::size_t kStatusesInFlight = 65'536;
constexpr std::size_t kLeastImages = 4;
constexpr std::size_t kMostImages = 64;

/// Everything but the sequences.
void copy_head(const msg::CommandFrame& from, msg::CommandFrame& to) {
  to.bench(from.bench());
  to.incarnation(from.incarnation());
  to.session(from.session());
  to.epoch(from.epoch());
  to.sequence_number(from.sequence_number());
  to.flags(from.flags());
  to.axes().clear();
}

void copy_head(const msg::Request& from, msg::Request& to) {
  to.client(from.client());
  to.request_id(from.request_id());
  to.bench(from.bench());
  to.incarnation(from.incarnation());
  to.session(from.session());
  to.kind(from.kind());
  to.axes().clear();
  to.objects().clear();
}

std::uint32_t bounds_refusal(const msg::CommandFrame& frame) {
  if (frame.axes().size() > msg::MAX_AXES_PER_FRAME) {
    return msg::REASON_TOO_MANY_AXES;
  }
  const bool fits = std::all_of(frame.axes().begin(), frame.axes().end(), [](const auto& axis) {
    return axis.objects().size() <= msg::MAX_OBJECTS_PER_AXIS;
  });
  return fits ? msg::REASON_NONE : msg::REASON_TOO_MANY_OBJECTS;
}

std::uint32_t bounds_refusal(const msg::Request& request) {
  if (request.axes().size() > msg::MAX_AXES_PER_FRAME) {
    return msg::REASON_TOO_MANY_AXES;
  }
  return request.objects().size() <= msg::MAX_OBJECTS_PER_REQUEST ? msg::REASON_NONE
                                                                  : msg::REASON_TOO_MANY_OBJECTS;
}

/// @return the reason why only the head was copied, or REASON_NONE.
template <typename Message>
std::uint32_t copy(const Message& from, Message& to) {
  const std::uint32_t refusal = bounds_refusal(from);
  if (refusal == msg::REASON_NONE) {
    to = from;
  } else {
    copy_head(from, to);
  }
  return refusal;
}

}  // namespace

Inbox::Inbox(std::uint32_t bench, Counters& counters)
    : bench_(bench), counters_(counters), arrivals_(kCapacity), turned_away_(kTurnedAway) {}

void Inbox::receive(const msg::CommandFrame& frame, const wire::Source& source) {
  if (frame.bench() != bench_) {
    return;
  }
  const std::lock_guard lock(producers_);
  Arrival* const slot = arrivals_.free_slot();
  if (slot == nullptr) {
    turn_away({.kind = Arrival::Kind::command_frame,
               .source = source,
               .session = frame.session(),
               .sequence_number = frame.sequence_number()});
    return;
  }
  slot->kind = Arrival::Kind::command_frame;
  slot->source = source;
  slot->refusal = copy(frame, slot->frame);
  arrivals_.push();
}

void Inbox::receive(const msg::Request& request, const wire::Source& source) {
  if (request.bench() != bench_) {
    return;
  }
  const std::lock_guard lock(producers_);
  Arrival* const slot = arrivals_.free_slot();
  if (slot == nullptr) {
    turn_away({.kind = Arrival::Kind::request,
               .source = source,
               .client = request.client(),
               .request_id = request.request_id(),
               .session = request.session()});
    return;
  }
  slot->kind = Arrival::Kind::request;
  slot->source = source;
  slot->refusal = copy(request, slot->request);
  arrivals_.push();
}

void Inbox::turn_away(const TurnedAway& arrival) {
  counters_.queue_overflows.add();
  if (auto* const slot = turned_away_.free_slot(); slot != nullptr) {
    *slot = arrival;
    turned_away_.push();
  }
}

Outbox::Outbox(std::size_t axes)
    : command_replies(kCommandReplies),
      replies(kReplies),
      events(kEvents),
      parameters(kParameters),
      status(std::clamp(kStatusesInFlight / axes, kLeastImages, kMostImages)) {
  command_replies.for_each_slot([](msg::CommandReply& reply) {
    reply.refusals().reserve(msg::MAX_AXES_PER_FRAME);
    reply.ignored_set_points().reserve(msg::MAX_AXES_PER_FRAME);
  });
  replies.for_each_slot([](OutgoingReply& outgoing) {
    outgoing.reply.objects().reserve(msg::MAX_OBJECTS_PER_REQUEST);
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

}  // namespace vdrive::service
