// SPDX-License-Identifier: Apache-2.0
#include "send_queue.hpp"

#include <gtest/gtest.h>

namespace vdrive::gateway {
namespace {

Frame frame_of(const std::string& bytes) {
  Frame frame;
  frame.body = std::make_shared<const std::string>(bytes);
  return frame;
}

std::string next(SendQueue& queue) {
  const auto frame = queue.pop();
  return frame ? *frame->body : "";
}

TEST(SendQueue, KeepsTheOrder) {
  SendQueue queue;
  queue.push_data(frame_of("a"));
  queue.push_data(frame_of("b"));
  EXPECT_EQ(next(queue), "a");
  EXPECT_EQ(next(queue), "b");
  EXPECT_EQ(next(queue), "");
}

TEST(SendQueue, DropsTheOldestDataAndCountsIt) {
  // 10 bytes hold two frames of four bytes.
  SendQueue queue({.data_bytes = 10, .data_frames = 100});
  for (const char* bytes : {"aaaa", "bbbb", "cccc", "dddd"}) queue.push_data(frame_of(bytes));
  EXPECT_EQ(queue.bytes(), 8U);
  EXPECT_EQ(queue.take_dropped(), 2U);
  EXPECT_EQ(queue.take_dropped(), 0U);
  EXPECT_EQ(next(queue), "cccc");
  EXPECT_EQ(next(queue), "dddd");
}

TEST(SendQueue, DropsTheOldestBeyondTheNumberOfFrames) {
  SendQueue queue({.data_bytes = 1000, .data_frames = 2});
  for (const char* bytes : {"a", "b", "c"}) queue.push_data(frame_of(bytes));
  EXPECT_EQ(queue.take_dropped(), 1U);
  EXPECT_EQ(next(queue), "b");
}

TEST(SendQueue, SendsTheNewestFrameOfAnySize) {
  SendQueue queue({.data_bytes = 3, .data_frames = 100});
  queue.push_data(frame_of("aa"));
  queue.push_data(frame_of("bbbbbbbb"));
  EXPECT_EQ(next(queue), "bbbbbbbb");
  EXPECT_EQ(queue.bytes(), 0U);
}

TEST(SendQueue, SendsAnswersFirstAndDropsNone) {
  SendQueue queue({.data_bytes = 4, .data_frames = 1, .answer_bytes = 10, .answer_frames = 10});
  queue.push_data(frame_of("data"));
  EXPECT_TRUE(queue.push_answer(frame_of("12345")));
  EXPECT_TRUE(queue.push_answer(frame_of("67890")));
  EXPECT_FALSE(queue.push_answer(frame_of("!")));
  EXPECT_EQ(next(queue), "12345");
  EXPECT_TRUE(queue.push_answer(frame_of("!")));
  EXPECT_EQ(next(queue), "67890");
  EXPECT_EQ(next(queue), "!");
  EXPECT_EQ(next(queue), "data");
  EXPECT_EQ(queue.take_dropped(), 0U);
}

TEST(SendQueue, CountsNoBytesOfSharedFrames) {
  SendQueue queue({.data_bytes = 4, .data_frames = 1, .answer_bytes = 2, .answer_frames = 2});
  EXPECT_TRUE(queue.push_answer(frame_of("a long advertisement"), true));
  EXPECT_EQ(queue.bytes(), 0U);
  EXPECT_TRUE(queue.push_answer(frame_of("a long advertisement"), true));
  EXPECT_FALSE(queue.push_answer(frame_of("a long advertisement"), true)) << "but their number";
}

}  // namespace
}  // namespace vdrive::gateway
