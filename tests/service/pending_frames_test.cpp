// SPDX-License-Identifier: Apache-2.0
#include "engine/pending_frames.hpp"

#include "core/support/allocation_guard.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace vdrive::service {
namespace {

bool insert(PendingFrames& frames, std::uint64_t tick, std::uint64_t sequence) {
  msg::CommandFrame frame;
  frame.sequence_number = sequence;
  return frames.insert(tick, frame);
}

std::vector<std::uint64_t> due_at(PendingFrames& frames, std::uint64_t tick) {
  std::vector<std::uint64_t> sequences;
  msg::CommandFrame frame;
  while (frames.take_due(tick, frame)) sequences.push_back(frame.sequence_number);
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
      [](const auto& head, auto /*commands*/) {
        return head.sequence_number % 2 == 0;
      },
      [&](const auto& head) {
        dropped.push_back(head.sequence_number);
      });
  EXPECT_EQ(dropped, (std::vector<std::uint64_t>{2, 4}));
  EXPECT_EQ(due_at(frames, 10), (std::vector<std::uint64_t>{1, 3}));
}

/// @return a frame with commands for the axes 1 to `count`, each with one object.
msg::CommandFrame frame_of(std::uint16_t count) {
  msg::CommandFrame frame;
  for (std::uint16_t axis = 1; axis <= count; ++axis) {
    auto& command = frame.axes.emplace_back();
    command.axis = axis;
    command.objects.emplace_back().value = axis;
  }
  return frame;
}

TEST(PendingFrames, GiveEachCommandBackWithItsObjects) {
  PendingFrames frames;
  auto large = frame_of(msg::MAX_AXES_PER_FRAME);
  auto small = frame_of(2);
  ASSERT_TRUE(frames.insert(5, large));
  ASSERT_TRUE(frames.insert(6, small));
  // First into a frame that has other commands, then into an empty one.
  auto due = frame_of(3);
  for (const std::uint16_t size : {std::uint16_t{msg::MAX_AXES_PER_FRAME}, std::uint16_t{2}}) {
    ASSERT_TRUE(frames.take_due(6, due));
    ASSERT_EQ(due.axes.size(), size);
    for (std::uint16_t axis = 1; axis <= size; ++axis) {
      const auto& command = due.axes[axis - 1U];
      EXPECT_EQ(command.axis, axis);
      ASSERT_EQ(command.objects.size(), 1U);
      EXPECT_EQ(command.objects.front().value, axis);
    }
    due.axes.clear();
  }
}

TEST(PendingFrames, AllocateNothingForTheLargestFramesEither) {
  PendingFrames frames;
  std::vector<msg::CommandFrame> sent(4, frame_of(msg::MAX_AXES_PER_FRAME));
  msg::CommandFrame due;
  due.axes.reserve(msg::MAX_AXES_PER_FRAME);
  const test::AllocationGuard guard;
  for (auto& frame : sent) ASSERT_TRUE(frames.insert(5, frame));
  while (frames.take_due(5, due)) ASSERT_EQ(due.axes.size(), msg::MAX_AXES_PER_FRAME);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace vdrive::service
