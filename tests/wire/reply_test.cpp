// SPDX-License-Identifier: Apache-2.0
// Our own encoder and decoder of replies, compared with those generated from the IDL.
#include "vdrive/wire/reply.hpp"

#include "vdrive/wire/codec.hpp"
#include "wire/made_status.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace vdrive::wire {
namespace {

using Bytes = std::vector<std::byte>;

ShownAxis make_axis(unsigned seed) {
  return {.number = static_cast<std::uint16_t>(seed + 7),
          .tick = 1'000 + seed,
          .owner = {.session = 0x5555'0000 + seed, .epoch = 4 + seed, .last_sequence = 900 + seed},
          .status = test::make_status(seed)};
}

msg::Reply make_reply(std::size_t objects) {
  msg::Reply reply;
  reply.client = 0x0123456789ABCDEF;
  reply.request_id = 5;
  reply.bench = 3;
  reply.incarnation = 0xFEDCBA9876543210;
  reply.reason = msg::Reason::too_many_ticks;
  reply.refused_axis = 9;
  reply.owner_session = 0x1111111122222222;
  reply.tick = 77;
  reply.epoch = 21;
  reply.last_sequence = 1'234'567'890'123;
  reply.missing_stepper = 0x3333333344444444;
  reply.snapshot = 6;
  for (std::size_t number = 0; number < objects; ++number) {
    auto& object = reply.objects.emplace_back();
    object.axis = static_cast<std::uint16_t>(number + 1);
    object.index = 0x6081;
    object.subindex = static_cast<std::uint8_t>(number);
    object.abort_code = static_cast<msg::Reason>(0x06090030);
    object.value = -5'000'000'000 + static_cast<std::int64_t>(number);
  }
  return reply;
}

Bytes encoded_by_us(const msg::Reply& reply, std::span<const ShownAxis> axes) {
  Bytes bytes(encoded_reply_size(reply, axes.size()));
  EXPECT_EQ(encode_reply(reply, axes, bytes), bytes.size());
  return bytes;
}

std::vector<ShownAxis> make_axes(std::size_t count) {
  std::vector<ShownAxis> axes;
  for (std::size_t number = 0; number < count; ++number) {
    axes.push_back(make_axis(static_cast<unsigned>(number)));
  }
  return axes;
}

/// An object takes 24 bytes and the axes follow a 4-byte number, so whether they begin at a
/// multiple of 8 depends on the bytes before them.
TEST(ReplyCodec, WritesTheBytesOfTheGeneratedEncoder) {
  for (std::size_t objects = 0; objects <= 3; ++objects) {
    for (std::size_t count = 0; count <= 4; ++count) {
      const msg::Reply reply = make_reply(objects);
      const auto axes = make_axes(count);
      msg::Reply whole = reply;
      for (const ShownAxis& axis : axes) {
        to_message(axis.status, {reply.bench, axis.number}, axis.tick, axis.owner,
                   whole.statuses.emplace_back());
      }
      Bytes expected(encoded_size(whole));
      ASSERT_EQ(encode(whole, expected), expected.size());
      EXPECT_EQ(encoded_by_us(reply, axes), expected)
          << objects << " objects, " << count << " axes";
    }
  }
}

TEST(ReplyCodec, ReadsWhatItWrote) {
  const msg::Reply reply = make_reply(2);
  const auto axes = make_axes(3);
  const Bytes sample = encoded_by_us(reply, axes);
  msg::Reply read;
  std::vector<ReceivedStatus> shown;
  ASSERT_TRUE(decode_reply(sample, read, shown));
  EXPECT_EQ(read, reply);
  ASSERT_EQ(shown.size(), axes.size());
  for (std::size_t number = 0; number < axes.size(); ++number) {
    EXPECT_EQ(shown[number].address.bench, 3U);
    EXPECT_EQ(shown[number].address.axis, axes[number].number);
    EXPECT_EQ(shown[number].tick, axes[number].tick);
    EXPECT_EQ(shown[number].owner.session, axes[number].owner.session);
    EXPECT_EQ(shown[number].owner.last_sequence, axes[number].owner.last_sequence);
    for (const StatusMember& member : status_members()) {
      if (!member.is_published) continue;
      EXPECT_EQ(member.value(shown[number].status), member.value(axes[number].status))
          << member.name;
    }
  }
}

TEST(ReplyCodec, RefusesASampleThatEndsEarly) {
  const Bytes sample = encoded_by_us(make_reply(1), make_axes(2));
  msg::Reply read;
  std::vector<ReceivedStatus> shown;
  for (std::size_t size = 0; size < sample.size(); ++size) {
    EXPECT_FALSE(decode_reply(std::span(sample).first(size), read, shown)) << size;
  }
}

TEST(ReplyCodec, RefusesCountsAboveTheBoundsOfTheIdl) {
  msg::Reply read;
  std::vector<ReceivedStatus> shown;
  msg::Reply objects = make_reply(65);
  EXPECT_FALSE(decode_reply(encoded_by_us(objects, {}), read, shown));
  EXPECT_FALSE(decode_reply(encoded_by_us(make_reply(0), make_axes(257)), read, shown));
  EXPECT_TRUE(decode_reply(encoded_by_us(make_reply(64), make_axes(256)), read, shown));
  EXPECT_EQ(shown.size(), 256U);
}

TEST(ReplyCodec, RefusesAnotherByteOrderAndAnotherEncapsulation) {
  msg::Reply read;
  std::vector<ReceivedStatus> shown;
  Bytes sample = encoded_by_us(make_reply(0), {});
  sample[1] = std::byte{0};  // big-endian
  EXPECT_FALSE(decode_reply(sample, read, shown));
  sample[1] = std::byte{3};  // a parameter list
  EXPECT_FALSE(decode_reply(sample, read, shown));
}

TEST(ReplyCodec, WritesNothingWithoutRoom) {
  const msg::Reply reply = make_reply(1);
  const auto axes = make_axes(1);
  Bytes room(encoded_reply_size(reply, 1) - 1);
  EXPECT_EQ(encode_reply(reply, axes, room), 0U);
}

}  // namespace
}  // namespace vdrive::wire
