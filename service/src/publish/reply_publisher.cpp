// SPDX-License-Identifier: Apache-2.0
#include "publish/reply_publisher.hpp"

#include <utility>

namespace vdrive::service {

ReplyPublisher::ReplyPublisher(WireLink& link, const BenchIdentity& identity, Counters& counters,
                               Complete complete)
    : link_(link), identity_(identity), counters_(counters), complete_(std::move(complete)) {
  command_reply_.refusals.reserve(msg::MAX_AXES_PER_FRAME);
  command_reply_.ignored_set_points.reserve(msg::MAX_AXES_PER_FRAME);
}

void ReplyPublisher::deliver(Inbox& inbox, Outbox& outbox, std::size_t most_pages) {
  while (OutgoingReply* const outgoing = outbox.replies.front()) {
    if (outgoing->page) {
      if (most_pages == 0) break;
      --most_pages;
      complete_(*outgoing);
    }
    if (!link_.post_to(outgoing->destination, outgoing->reply, outgoing->axes)) break;
    outbox.replies.pop();
  }
  while (const StoredCommandReply* const reply = outbox.command_replies.front()) {
    reply->show(command_reply_);
    if (!link_.post(Lane::replies, command_reply_)) break;
    outbox.command_replies.pop();
  }
  while (const auto arrival = inbox.next_turned_away()) {
    if (!refuse(*arrival)) counters_.queue_overflows.add();
  }
  link_.flush(Lane::replies);
}

bool ReplyPublisher::refuse(const TurnedAway& arrival) {
  counters_.refusals.add(wire::number(msg::Reason::queue_full));
  if (arrival.kind == Arrival::Kind::request) {
    msg::Reply reply;
    reply.client = arrival.client;
    reply.request_id = arrival.request_id;
    reply.bench = identity_.bench;
    reply.incarnation = identity_.incarnation;
    reply.reason = msg::Reason::queue_full;
    reply.tick = counters_.tick.get();
    return link_.post_to(arrival.source, reply);
  }
  msg::CommandReply reply;
  reply.bench = identity_.bench;
  reply.incarnation = identity_.incarnation;
  reply.session = arrival.session;
  reply.sequence_number = arrival.sequence_number;
  reply.tick = counters_.tick.get();
  reply.refusals.emplace_back().reason = msg::Reason::queue_full;
  return link_.post(Lane::replies, reply);
}

}  // namespace vdrive::service
