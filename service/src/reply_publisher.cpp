// SPDX-License-Identifier: Apache-2.0
#include "reply_publisher.hpp"

#include <spdlog/spdlog.h>

namespace vdrive::service {

ReplyPublisher::ReplyPublisher(wire::Participant& participant, const BenchIdentity& identity,
                               Counters& counters)
    : replies_(participant),
      command_replies_(participant),
      identity_(identity),
      counters_(counters) {}

void ReplyPublisher::deliver(Inbox& inbox, Outbox& outbox) {
  while (const OutgoingReply* const outgoing = outbox.replies.front()) {
    send(*outgoing);
    outbox.replies.pop();
  }
  while (const msg::CommandReply* const reply = outbox.command_replies.front()) {
    if (!command_replies_.write(*reply)) {
      counters_.queue_overflows.add();
    }
    outbox.command_replies.pop();
  }
  while (const TurnedAway* const arrival = inbox.turned_away().front()) {
    refuse(*arrival);
    inbox.turned_away().pop();
  }
  if (!waiting_.empty()) {
    retry();
  }
}

void ReplyPublisher::send(const OutgoingReply& outgoing) {
  if (try_send(outgoing)) {
    return;
  }
  if (waiting_.size() < kMostWaiting) {
    waiting_.push_back({outgoing, Clock::now() + kLongestWait});
  } else {
    drop(outgoing.reply, "too many wait for their readers");
  }
}

void ReplyPublisher::drop(const msg::Reply& reply, std::string_view why) {
  counters_.queue_overflows.add();
  if (const auto suppressed = drop_log_.pass(Clock::now())) {
    spdlog::warn("reply=dropped bench={} client=0x{:016X} request={} suppressed={} text=\"{}\"",
                 identity_.bench, reply.client(), reply.request_id(), *suppressed, why);
  }
}

bool ReplyPublisher::try_send(const OutgoingReply& outgoing) {
  if (!is_matched(outgoing.destination)) {
    return false;
  }
  if (!replies_.write(outgoing.reply)) {
    drop(outgoing.reply, "its queue is full");
  }
  return true;
}

void ReplyPublisher::retry() {
  const auto now = Clock::now();
  std::erase_if(waiting_, [&](const Waiting& waiting) {
    if (try_send(waiting.outgoing)) {
      return true;
    }
    if (now < waiting.deadline) {
      return false;
    }
    drop(waiting.outgoing.reply, "nobody reads it");
    return true;
  });
}

void ReplyPublisher::refuse(const TurnedAway& arrival) {
  counters_.refusals.add(msg::REASON_QUEUE_FULL);
  if (arrival.kind == Arrival::Kind::request) {
    OutgoingReply outgoing;
    outgoing.destination = arrival.source;
    outgoing.reply.client(arrival.client);
    outgoing.reply.request_id(arrival.request_id);
    outgoing.reply.bench(identity_.bench);
    outgoing.reply.incarnation(identity_.incarnation);
    outgoing.reply.reason(msg::REASON_QUEUE_FULL);
    outgoing.reply.tick(counters_.tick.get());
    send(outgoing);
    return;
  }
  msg::CommandReply reply;
  reply.bench(identity_.bench);
  reply.incarnation(identity_.incarnation);
  reply.session(arrival.session);
  reply.sequence_number(arrival.sequence_number);
  reply.tick(counters_.tick.get());
  reply.refusals().emplace_back().reason(msg::REASON_QUEUE_FULL);
  if (!command_replies_.write(reply)) {
    counters_.queue_overflows.add();
  }
}

}  // namespace vdrive::service
