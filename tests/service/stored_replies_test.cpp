// SPDX-License-Identifier: Apache-2.0
#include "seam/stored_replies.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace vdrive::service {
namespace {

/// Gives every member of the IDL type a different value.
msg::CommandReply command_reply(std::uint32_t first, std::size_t refusals) {
  msg::CommandReply reply;
  reply.bench = first;
  reply.incarnation = first + 1;
  reply.session = first + 2;
  reply.sequence_number = first + 3;
  reply.tick = first + 4;
  for (std::size_t i = 0; i < refusals; ++i) {
    msg::Refusal& refusal = reply.refusals.emplace_back();
    refusal.axis = static_cast<std::uint16_t>(first + i);
    refusal.index = static_cast<std::uint16_t>(first + i + 1);
    refusal.subindex = static_cast<std::uint8_t>(i);
    refusal.reason = msg::Reason{first + 5};
  }
  reply.ignored_set_points.push_back(static_cast<std::uint16_t>(first + 6));
  return reply;
}

msg::Reply reply_to_request(std::uint32_t first, std::size_t objects) {
  msg::Reply reply;
  reply.client = first;
  reply.request_id = first + 1;
  reply.bench = first + 2;
  reply.incarnation = first + 3;
  reply.reason = msg::Reason{first + 4};
  reply.refused_axis = static_cast<std::uint16_t>(first + 5);
  reply.owner_session = first + 6;
  reply.tick = first + 7;
  reply.epoch = first + 8;
  reply.last_sequence = first + 9;
  reply.missing_stepper = first + 10;
  reply.snapshot = first + 11;
  for (std::size_t i = 0; i < objects; ++i) {
    msg::ObjectResult& object = reply.objects.emplace_back();
    object.axis = static_cast<std::uint16_t>(first + i);
    object.index = static_cast<std::uint16_t>(first + i + 1);
    object.abort_code = msg::Reason{first + 12};
    object.value = static_cast<std::int64_t>(first) + 13;
  }
  return reply;
}

TEST(StoredCommandReply, ShowsEveryMemberOfTheReplyThatItKeptLast) {
  StoredCommandReply stored;
  msg::CommandReply shown = command_reply(900, 7);
  for (const std::size_t refusals :
       {std::size_t{3}, std::size_t{msg::MAX_AXES_PER_FRAME}, std::size_t{1}}) {
    const msg::CommandReply reply = command_reply(100, refusals);
    stored.keep(reply);
    stored.show(shown);
    EXPECT_TRUE(shown == reply) << refusals;
  }
}

TEST(StoredReply, ShowsEveryMemberOfTheReplyThatItKeptLastButStatuses) {
  StoredReply stored;
  msg::Reply shown = reply_to_request(900, 7);
  for (const std::size_t objects :
       {std::size_t{3}, std::size_t{msg::MAX_OBJECTS_PER_REQUEST}, std::size_t{1}}) {
    const msg::Reply reply = reply_to_request(100, objects);
    stored.keep(reply);
    stored.show(shown);
    EXPECT_TRUE(shown == reply) << objects;
  }
}

}  // namespace
}  // namespace vdrive::service
