// SPDX-License-Identifier: Apache-2.0
// Encoder and decoder; bytes_test.cpp compares them with Fast DDS.
#include "vdrive/wire/codec.hpp"

#include "vdrive/wire/cdr.hpp"
#include "vdrive/wire/status_frame.hpp"
#include "wire/made_status.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace vdrive::wire {
namespace {

using test::make_status;

using Bytes = std::vector<std::byte>;

template <typename Message>
Bytes encoded(const Message& message) {
  Bytes bytes(encoded_size(message));
  EXPECT_EQ(encode(message, bytes), bytes.size());
  return bytes;
}

template <typename Message>
Bytes encoded_big_endian(const Message& message) {
  Bytes bytes(encoded_size(message));
  CdrWriter writer(bytes, CdrWriter::Order::big_endian);
  writer.put(message);
  EXPECT_TRUE(writer.is_good());
  return bytes;
}

TEST(StatusCodec, WritesTheBytesOfTheMessage) {
  constexpr std::size_t kAxes = 5;
  std::vector<AxisStatus> status;
  std::vector<Ownership> owners;
  std::vector<std::uint16_t> numbers;
  msg::StatusFrame message;
  message.bench = 3;
  message.skipped_ticks = 9'003;
  message.incarnation = 0x0123456789ABCDEF;
  message.tick = 77;
  message.time_ns = -5;
  message.part = 2;
  message.parts = 9;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    status.push_back(make_status(static_cast<unsigned>(axis)));
    owners.push_back({.session = 0xFEDC0000 + axis, .epoch = 4, .last_sequence = 1'000 + axis});
    numbers.push_back(static_cast<std::uint16_t>(300 + axis));
    to_message(status.back(), {3, numbers.back()}, 77, owners.back(), message.axes.emplace_back());
  }
  Bytes bytes(encoded_status_frame_size(kAxes));
  ASSERT_EQ(encode_status_frame({.bench = 3,
                                 .skipped_ticks = 9'003,
                                 .incarnation = 0x0123456789ABCDEF,
                                 .tick = 77,
                                 .time_ns = -5,
                                 .part = 2,
                                 .parts = 9},
                                {.status = status, .owners = owners, .numbers = numbers}, bytes),
            bytes.size());
  EXPECT_EQ(bytes, encoded(message));

  Bytes sample(kAxisStatusSize);
  ASSERT_EQ(encode_axis_status(status[1], {3, numbers[1]}, 77, owners[1], sample), sample.size());
  EXPECT_EQ(sample, encoded(message.axes[1]));
}

TEST(StatusCodec, WritesNothingWithoutRoom) {
  const std::vector<AxisStatus> status(2);
  const std::vector<Ownership> owners(2);
  const std::vector<std::uint16_t> numbers{1, 2};
  Bytes bytes(encoded_status_frame_size(2) - 1, std::byte{0x55});
  EXPECT_EQ(
      encode_status_frame({}, {.status = status, .owners = owners, .numbers = numbers}, bytes), 0U);
  EXPECT_EQ(bytes, Bytes(bytes.size(), std::byte{0x55}));
}

/// @return a frame of `count` axes.
Bytes status_frame(std::size_t count) {
  std::vector<AxisStatus> status;
  std::vector<Ownership> owners;
  std::vector<std::uint16_t> numbers;
  for (std::size_t axis = 0; axis < count; ++axis) {
    status.push_back(make_status(static_cast<unsigned>(axis)));
    status.back().ds402_controlword = 0;  // not on the wire
    owners.push_back({.session = 0xFEDC0000 + axis, .epoch = 4, .last_sequence = 1'000 + axis});
    numbers.push_back(static_cast<std::uint16_t>(300 + axis));
  }
  Bytes bytes(encoded_status_frame_size(count));
  EXPECT_EQ(encode_status_frame({.bench = 3,
                                 .skipped_ticks = 9'003,
                                 .incarnation = 0x0123456789ABCDEF,
                                 .tick = 77,
                                 .time_ns = -5,
                                 .part = 2,
                                 .parts = 9},
                                {.status = status, .owners = owners, .numbers = numbers}, bytes),
            bytes.size());
  return bytes;
}

/// @return the bytes of all members, encoded through the message.
Bytes bytes_of(const ReceivedStatus& received) {
  msg::AxisStatus message;
  to_message(received.status, received.address, received.tick, received.owner, message);
  return encoded(message);
}

TEST(StatusFrameView, ReadsTheSameValuesAsTheMessage) {
  constexpr std::size_t kAxes = 5;
  const Bytes sample = status_frame(kAxes);
  msg::StatusFrame message;
  ASSERT_TRUE(decode(sample, message));
  const auto sut = StatusFrameView::of(sample);
  ASSERT_TRUE(sut.has_value());
  EXPECT_EQ(sut->head().bench, 3U);
  EXPECT_EQ(sut->head().skipped_ticks, 9'003U);
  EXPECT_EQ(sut->head().incarnation, 0x0123456789ABCDEFU);
  EXPECT_EQ(sut->head().tick, 77U);
  EXPECT_EQ(sut->head().time_ns, -5);
  EXPECT_EQ(sut->head().part, 2U);
  EXPECT_EQ(sut->head().parts, 9U);
  ASSERT_EQ(sut->size(), kAxes);
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    EXPECT_EQ(sut->number(axis), 300 + axis);
    EXPECT_EQ(bytes_of(sut->axis(axis)), encoded(message.axes[axis])) << axis;
  }
}

TEST(StatusFrameView, AcceptsWholeFramesOnly) {
  const Bytes sample = status_frame(3);
  for (std::size_t size = 0; size < sample.size(); ++size) {
    EXPECT_FALSE(StatusFrameView::of(std::span(sample).first(size)).has_value()) << size;
  }
  EXPECT_TRUE(StatusFrameView::of(sample).has_value());
  EXPECT_EQ(StatusFrameView::of(status_frame(0))->size(), 0U);
}

TEST(StatusFrameView, RefusesMoreAxesThanAFrameMayHold) {
  EXPECT_EQ(StatusFrameView::of(status_frame(256))->size(), 256U);
  EXPECT_FALSE(StatusFrameView::of(status_frame(257)).has_value());
}

TEST(StatusFrameView, AcceptsPlainLittleEndianCdrOnly) {
  for (const std::size_t byte : {0U, 1U}) {
    Bytes sample = status_frame(1);
    sample[byte] ^= std::byte{1};
    EXPECT_FALSE(StatusFrameView::of(sample).has_value());
  }
}

msg::CommandFrame make_frame(std::size_t axes, std::size_t objects) {
  msg::CommandFrame frame;
  frame.bench = 7;
  frame.incarnation = 8;
  frame.session = 9;
  frame.epoch = 10;
  frame.sequence_number = 11;
  frame.apply_at_tick = 12;
  frame.valid_until_tick = 13;
  frame.flags = 14;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    auto& command = frame.axes.emplace_back();
    command.axis = static_cast<std::uint16_t>(axis + 1);
    command.members = 0x7F;
    command.ds402_controlword = 0x1F;
    command.op_mode_cmd = -3;
    command.position_user_target_value = -1'234;
    command.profile_velocity = 5;
    command.profile_acc = 6;
    command.profile_dec = 7;
    command.positioning_option_code = 8;
    for (std::size_t object = 0; object < objects + axis % 2; ++object) {
      auto& value = command.objects.emplace_back();
      value.index = 0x6067;
      value.subindex = static_cast<std::uint8_t>(object);
      value.value = -static_cast<std::int64_t>(object) - 1;
    }
  }
  return frame;
}

msg::Request make_request(std::size_t axes, std::size_t objects) {
  msg::Request request;
  request.client = 1;
  request.request_id = 2;
  request.bench = 3;
  request.incarnation = 4;
  request.session = 5;
  request.kind = msg::RequestKind::take_over;
  request.ticks = 7;
  request.last_sequence = 8;
  request.rate = 0.25;
  request.snapshot = 9;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    request.axes.push_back(static_cast<std::uint16_t>(axis));
  }
  for (std::size_t object = 0; object < objects; ++object) {
    auto& access = request.objects.emplace_back();
    access.axis = static_cast<std::uint16_t>(object);
    access.index = 0x6081;
    access.subindex = 1;
    access.value = -7;
  }
  return request;
}

TEST(CommandDecoder, ReadsMessagesOfBothByteOrders) {
  CommandDecoder decoder;
  msg::CommandFrame frame;
  msg::Request request;
  // Alternately larger and smaller: decoding must not depend on the previous message.
  for (const std::size_t size : {0U, 256U, 1U, 40U, 3U}) {
    const auto sent = make_frame(size, 3);
    EXPECT_EQ(decoder.decode(encoded(sent), frame), Decoding::good);
    EXPECT_EQ(frame, sent) << size;
    EXPECT_EQ(decoder.decode(encoded_big_endian(sent), frame), Decoding::good);
    EXPECT_EQ(frame, sent) << size;
    const auto asked = make_request(size, size % 65);
    EXPECT_EQ(decoder.decode(encoded(asked), request), Decoding::good);
    EXPECT_EQ(request, asked) << size;
    EXPECT_EQ(decoder.decode(encoded_big_endian(asked), request), Decoding::good);
    EXPECT_EQ(request, asked) << size;
  }
}

TEST(CommandDecoder, ReportsEveryTruncatedSampleAsMalformed) {
  CommandDecoder decoder;
  msg::CommandFrame frame;
  msg::Request request;
  const Bytes sent = encoded(make_frame(3, 2));
  const Bytes asked = encoded(make_request(3, 2));
  for (std::size_t size = 0; size < sent.size(); ++size) {
    EXPECT_EQ(decoder.decode(std::span(sent).first(size), frame), Decoding::malformed) << size;
  }
  for (std::size_t size = 0; size < asked.size(); ++size) {
    EXPECT_EQ(decoder.decode(std::span(asked).first(size), request), Decoding::malformed) << size;
  }
}

TEST(CommandDecoder, ReadsTheHeaderOfAMessageBeyondItsBounds) {
  CommandDecoder decoder;
  msg::CommandFrame frame;
  EXPECT_EQ(decoder.decode(encoded(make_frame(257, 0)), frame), Decoding::beyond_bounds);
  EXPECT_EQ(decoder.too_long(), msg::Reason::too_many_axes);
  EXPECT_EQ(frame.sequence_number, 11U);
  EXPECT_TRUE(frame.axes.empty());
  EXPECT_EQ(decoder.decode(encoded(make_frame(1, 9)), frame), Decoding::beyond_bounds);
  EXPECT_EQ(decoder.too_long(), msg::Reason::too_many_objects);
  EXPECT_EQ(frame.session, 9U);
  EXPECT_TRUE(frame.axes.empty());
  msg::Request request;
  EXPECT_EQ(decoder.decode(encoded(make_request(257, 0)), request), Decoding::beyond_bounds);
  EXPECT_EQ(decoder.too_long(), msg::Reason::too_many_axes);
  EXPECT_EQ(decoder.decode(encoded(make_request(2, 65)), request), Decoding::beyond_bounds);
  EXPECT_EQ(decoder.too_long(), msg::Reason::too_many_objects);
  EXPECT_EQ(request.request_id, 2U);
  EXPECT_TRUE(request.axes.empty());
}

TEST(CommandDecoder, AcceptsPlainCdrOnly) {
  CommandDecoder decoder;
  msg::CommandFrame frame;
  Bytes sample = encoded(make_frame(1, 0));
  for (const unsigned kind : {2U, 3U, 6U, 7U, 0xFFU}) {
    sample[1] = static_cast<std::byte>(kind);
    EXPECT_EQ(decoder.decode(sample, frame), Decoding::malformed) << kind;
  }
}

TEST(Codec, DecodesEveryEncodedMessageUnchanged) {
  msg::BenchState state;
  state.bench = 2;
  state.lateness_histogram = {1, 2, 3};
  state.wire_starts = 4;
  state.longest_silence_us = 5;
  msg::BenchState read;
  ASSERT_TRUE(decode(encoded(state), read));
  EXPECT_EQ(read, state);
  Bytes bytes = encoded(state);
  bytes.resize(bytes.size() / 2);
  EXPECT_FALSE(decode(bytes, read));
  EXPECT_FALSE(decode(Bytes{}, read));
}

}  // namespace
}  // namespace vdrive::wire
