// SPDX-License-Identifier: Apache-2.0
// The set-point handshake alone: bits 4 and 5 of the controlword, bit 12 of the statusword, one
// buffered set-point.
#include "vdrive/motion/set_point_queue.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace vdrive {
namespace {

constexpr std::uint16_t kBit4Low = 0x000F;
constexpr std::uint16_t kEdge = 0x001F;
constexpr std::uint16_t kImmediateEdge = 0x003F;

/// A queue and the previous controlword; takes controlwords as a master writes them.
class SetPointHandshake : public testing::Test {
 protected:
  SetPointOutcome write(std::uint16_t word, bool moving, const SetPoint& candidate = {}) {
    const std::uint16_t previous = previous_;
    previous_ = word;
    return queue.controlword(word, previous, accepting, moving, candidate);
  }

  SetPointQueue queue;
  bool accepting = true;

 private:
  std::uint16_t previous_ = kBit4Low;
};

TEST_F(SetPointHandshake, StartsWithoutAcknowledge) {
  EXPECT_FALSE(queue.acknowledge());
  EXPECT_FALSE(queue.full());
}

TEST_F(SetPointHandshake, StartsAtOnceWhenNothingMoves) {
  EXPECT_EQ(write(kEdge, false), SetPointOutcome::started);
  EXPECT_TRUE(queue.acknowledge());
  EXPECT_FALSE(queue.full());
}

TEST_F(SetPointHandshake, OnlyTheRisingEdgeLatches) {
  write(kEdge, false);

  EXPECT_EQ(write(kEdge, false), SetPointOutcome::none);
  EXPECT_EQ(write(kImmediateEdge, true), SetPointOutcome::none) << "bit 5 alone is no edge";
  EXPECT_EQ(write(kBit4Low, true), SetPointOutcome::none);
}

TEST_F(SetPointHandshake, AcknowledgeStaysWhileBit4IsHeld) {
  write(kEdge, false);
  write(kEdge, true);
  EXPECT_TRUE(queue.acknowledge());

  write(kBit4Low, true);
  EXPECT_FALSE(queue.acknowledge());
}

TEST_F(SetPointHandshake, SecondSetPointIsBufferedAndKeepsTheAcknowledge) {
  write(kEdge, false);
  write(kBit4Low, true);

  EXPECT_EQ(write(kEdge, true, {.position_user_target_value = 2}), SetPointOutcome::buffered);
  write(kBit4Low, true);
  EXPECT_TRUE(queue.acknowledge()) << "the buffer is full";
  EXPECT_TRUE(queue.full());

  SetPoint next;
  EXPECT_TRUE(queue.take_buffered(kBit4Low, next));
  EXPECT_EQ(next.position_user_target_value, 2);
  EXPECT_FALSE(queue.acknowledge());
  EXPECT_FALSE(queue.full());
}

TEST_F(SetPointHandshake, TakingTheBufferKeepsTheAcknowledgeWhileBit4IsHeld) {
  write(kEdge, false);
  write(kBit4Low, true);
  write(kEdge, true);

  SetPoint next;
  EXPECT_TRUE(queue.take_buffered(kEdge, next));
  EXPECT_TRUE(queue.acknowledge());
  write(kBit4Low, true);
  EXPECT_FALSE(queue.acknowledge());
}

TEST_F(SetPointHandshake, ThirdSetPointIsIgnoredAndTheBufferedOneIsKept) {
  write(kEdge, false, {.position_user_target_value = 1});
  write(kBit4Low, true);
  write(kEdge, true, {.position_user_target_value = 2});
  write(kBit4Low, true);

  EXPECT_EQ(write(kEdge, true, {.position_user_target_value = 3}), SetPointOutcome::ignored);
  EXPECT_TRUE(queue.acknowledge());
  SetPoint next;
  ASSERT_TRUE(queue.take_buffered(kBit4Low, next));
  EXPECT_EQ(next.position_user_target_value, 2);
}

TEST_F(SetPointHandshake, ImmediateSetPointRunsAtOnceAndEmptiesTheBuffer) {
  write(kEdge, false);
  write(kBit4Low, true);
  write(kEdge, true);
  write(kBit4Low, true);

  EXPECT_EQ(write(kImmediateEdge, true), SetPointOutcome::started);
  EXPECT_FALSE(queue.full());
  EXPECT_TRUE(queue.acknowledge());
  SetPoint next;
  EXPECT_FALSE(queue.take_buffered(kImmediateEdge, next));
}

TEST_F(SetPointHandshake, BufferKeepsVelocityAndRelativeFlagOfItsEdge) {
  write(kEdge, false);
  write(kBit4Low, true);
  write(kEdge, true,
        {.position_user_target_value = -7, .profile_velocity = 0xFFFFFFFF, .relative = true});

  SetPoint next;
  ASSERT_TRUE(queue.take_buffered(kBit4Low, next));
  EXPECT_EQ(next.position_user_target_value, -7);
  EXPECT_EQ(next.profile_velocity, 0xFFFFFFFFU);
  EXPECT_TRUE(next.relative);
}

TEST_F(SetPointHandshake, EdgeIsIgnoredAndNotAcknowledgedWhenTheDriveAcceptsNone) {
  accepting = false;

  EXPECT_EQ(write(kEdge, false), SetPointOutcome::ignored);
  EXPECT_FALSE(queue.acknowledge());

  accepting = true;
  EXPECT_EQ(write(kEdge, false), SetPointOutcome::none) << "a held bit 4 is no edge";
  EXPECT_FALSE(queue.acknowledge());
}

TEST_F(SetPointHandshake, DroppingTheBufferKeepsTheAcknowledgeWhileBit4IsHeld) {
  write(kEdge, false);
  write(kBit4Low, true);
  write(kEdge, true);

  queue.drop_buffered(kEdge);
  EXPECT_FALSE(queue.full());
  EXPECT_TRUE(queue.acknowledge());
  write(kBit4Low, true);
  EXPECT_FALSE(queue.acknowledge());

  write(kEdge, true);
  queue.drop_buffered(kBit4Low);
  EXPECT_FALSE(queue.acknowledge());
}

TEST_F(SetPointHandshake, ClearDropsBufferAndAcknowledge) {
  write(kEdge, false);
  write(kBit4Low, true);
  write(kEdge, true);

  queue.clear();

  EXPECT_FALSE(queue.acknowledge());
  EXPECT_FALSE(queue.full());
  SetPoint next;
  EXPECT_FALSE(queue.take_buffered(kEdge, next));
}

}  // namespace
}  // namespace vdrive
