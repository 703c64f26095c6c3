// SPDX-License-Identifier: Apache-2.0
#include "engine/pending_frames.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace vdrive::service {
namespace {

bool insert(PendingFrames& frames, std::uint64_t tick, std::uint64_t sequence) {
  msg::CommandFrame frame;
  frame.sequence_number(sequence);
  return frames.insert(tick, frame);
}

std::vector<std::uint64_t> due_at(PendingFrames& frames, std::uint64_t tick) {
  std::vector<std::uint64_t> sequences;
  msg::CommandFrame frame;
  while (frames.take_due(tick, frame)) sequences.push_back(frame.sequence_number());
  return sequences;
}

TEST(PendingFrames, AreDueInOrderOfTickThenOfArrival) {
  PendingFrames frames;
  ASSERT_TRUE(insert(frames, 30, 1));
  ASSERT_TRUE(insert(frames, 10, 2));
  ASSERT_TRUE(insert(frames, 20, 3));
  ASSERT_TRUE(insert(frames, 10, 4));
  EXPECT_EQ(due_at(frames, 9), std::vector<std::uint64_t>{});
  EXPECT_EQ(due_at(frames, 20), (std::vector<std::uint64_t>{2, 4, 3}));
  EXPECT_EQ(due_at(frames, 1'000), std::vector<std::uint64_t>{1});
  EXPECT_EQ(frames.size(), 0U);
}

TEST(PendingFrames, HaveRoomForAThousandAndTwentyFour) {
  PendingFrames frames;
  for (std::uint64_t sequence = 1; sequence <= PendingFrames::kCapacity; ++sequence) {
    ASSERT_TRUE(insert(frames, 5, sequence));
  }
  EXPECT_FALSE(insert(frames, 5, 9'999));
  EXPECT_EQ(due_at(frames, 5).size(), PendingFrames::kCapacity);
  EXPECT_TRUE(insert(frames, 5, 1));
}

TEST(PendingFrames, DropMatchingFramesAndReturnThem) {
  PendingFrames frames;
  for (std::uint64_t sequence = 1; sequence <= 4; ++sequence) {
    ASSERT_TRUE(insert(frames, sequence, sequence));
  }
  std::vector<std::uint64_t> dropped;
  frames.drop_if(
      [](const auto& frame) {
        return frame.sequence_number() % 2 == 0;
      },
      [&](const auto& frame) {
        dropped.push_back(frame.sequence_number());
      });
  EXPECT_EQ(dropped, (std::vector<std::uint64_t>{2, 4}));
  EXPECT_EQ(due_at(frames, 10), (std::vector<std::uint64_t>{1, 3}));
}

}  // namespace
}  // namespace vdrive::service
