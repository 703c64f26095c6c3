// SPDX-License-Identifier: Apache-2.0
// Status frames are combined into samples of the wanted axes; missing ones are counted.
#include "streams/status_feed.hpp"

#include "vdrive/wire/codec.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

constexpr BenchKey kBench{1, 10};

msg::StatusFrame frame(std::uint64_t tick, std::initializer_list<std::uint16_t> axes) {
  msg::StatusFrame message;
  message.bench = kBench.number;
  message.incarnation = kBench.incarnation;
  message.tick = tick;
  for (const std::uint16_t axis : axes) {
    msg::AxisStatus status;
    status.bench = kBench.number;
    status.axis = axis;
    status.tick = tick;
    message.axes.push_back(status);
  }
  return message;
}

/// Encodes frames as they arrive from the network.
class Feed {
 public:
  Feed(std::vector<std::uint16_t> axes, std::uint32_t status_every_ticks,
       std::uint64_t first_tick = 0)
      : feed_(kBench, std::move(axes), status_every_ticks, first_tick) {}

  bool on_frame(const msg::StatusFrame& message) {
    std::vector<std::byte> sample(wire::encoded_size(message));
    EXPECT_EQ(wire::encode(message, sample), sample.size());
    return feed_.on_frame(wire::StatusFrameView::of(sample).value());
  }

  [[nodiscard]] bool wants(const msg::StatusFrame& message) const {
    std::vector<std::byte> sample(wire::encoded_size(message));
    EXPECT_EQ(wire::encode(message, sample), sample.size());
    return feed_.wants(range_of(wire::StatusFrameView::of(sample).value()));
  }

  std::optional<Observation> take() { return feed_.take(); }

  bool take(Observation& sample) { return feed_.take(sample); }

 private:
  StatusFeed feed_;
};

TEST(StatusFeed, GivesTheAxesInTheRequestedOrder) {
  Feed sut({3, 1}, 1);
  sut.on_frame(frame(5, {1, 2, 3}));
  const auto sample = sut.take();
  ASSERT_TRUE(sample.has_value());
  EXPECT_EQ(sample->tick, 5U);
  EXPECT_EQ(sample->axes[0].id.axis, 3);
  EXPECT_EQ(sample->axes[1].id.axis, 1);
  EXPECT_FALSE(sut.take().has_value());
}

// A bench in lock-step shows tick 0 before its first step.
TEST(StatusFeed, BeginsWithTick0) {
  Feed sut({1, 300}, 1);
  sut.on_frame(frame(0, {1}));
  sut.on_frame(frame(0, {300}));
  const auto sample = sut.take();
  ASSERT_TRUE(sample.has_value());
  EXPECT_EQ(sample->tick, 0U);
}

// A frame from before the call may still be on its way to the reader.
TEST(StatusFeed, LeavesOutFramesFromBeforeItsFirstTick) {
  Feed sut({1}, 1, 5);
  EXPECT_FALSE(sut.on_frame(frame(4, {1})));
  EXPECT_TRUE(sut.on_frame(frame(5, {1})));
  const auto sample = sut.take();
  ASSERT_TRUE(sample.has_value());
  EXPECT_EQ(sample->tick, 5U);
  EXPECT_EQ(sample->missed, 0U) << "tick 4 was not asked for";
}

TEST(StatusFeed, CombinesThePartsOfATick) {
  Feed sut({1, 300}, 1);
  sut.on_frame(frame(5, {1}));
  EXPECT_FALSE(sut.take().has_value());
  sut.on_frame(frame(5, {300}));
  EXPECT_TRUE(sut.take().has_value());
}

// The axes may be in any order: frames from strangers need not be sorted.
TEST(StatusFeed, WantsNoFrameWhoseAxesAreAllBelowOrAboveItsOwn) {
  const Feed sut({300, 290}, 1);
  EXPECT_TRUE(sut.wants(frame(5, {300, 512, 257})));
  EXPECT_TRUE(sut.wants(frame(5, {290})));
  EXPECT_TRUE(sut.wants(frame(5, {1, 295})));
  EXPECT_FALSE(sut.wants(frame(5, {289, 1, 256})));
  EXPECT_FALSE(sut.wants(frame(5, {512, 301})));
}

// on_frame() returns true for the frame that wakes the waiting call, once per tick.
TEST(StatusFeed, ReportsWhichFrameCompletesASample) {
  Feed sut({1, 300}, 1);
  EXPECT_FALSE(sut.on_frame(frame(5, {1})));
  EXPECT_TRUE(sut.on_frame(frame(5, {300})));
  EXPECT_FALSE(sut.on_frame(frame(4, {1, 300})));
}

// The second call returns the memory of the sample of tick 1 for reuse by tick 3.
TEST(StatusFeed, ReusesTheMemoryOfTakenSamples) {
  Feed sut({1, 300}, 1);
  Observation sample;
  sut.on_frame(frame(1, {1, 300}));
  ASSERT_TRUE(sut.take(sample));
  const AxisSnapshot* const first = sample.axes.data();
  sut.on_frame(frame(2, {1, 300}));
  ASSERT_TRUE(sut.take(sample));
  EXPECT_NE(sample.axes.data(), first);
  sut.on_frame(frame(3, {1, 300}));
  ASSERT_TRUE(sut.take(sample));
  EXPECT_EQ(sample.axes.data(), first);
  EXPECT_EQ(sample.tick, 3U);
  EXPECT_EQ(sample.missed, 0U);
  for (const AxisSnapshot& axis : sample.axes) EXPECT_EQ(axis.tick, 3U);
}

TEST(StatusFeed, LeavesTheSampleUnchangedWhenNoneHasArrived) {
  Feed sut({1}, 1);
  Observation sample{.tick = 7, .missed = 2, .axes = {{}, {}}};
  EXPECT_FALSE(sut.take(sample));
  EXPECT_EQ(sample.tick, 7U);
  EXPECT_EQ(sample.missed, 2U);
  EXPECT_EQ(sample.axes.size(), 2U);
}

// A sample of another feed has another size, so its memory is not kept.
TEST(StatusFeed, DoesNotReuseMemoryOfAnotherSize) {
  Feed sut({1, 300}, 1);
  Observation sample{.tick = 7, .missed = 2, .axes = {{}, {}, {}}};
  for (const std::uint64_t tick : {1U, 2U, 3U, 4U}) {
    sut.on_frame(frame(tick, {1, 300}));
    ASSERT_TRUE(sut.take(sample));
    EXPECT_EQ(sample.axes.size(), 2U);
    EXPECT_EQ(sample.axes[1].id.axis, 300);
  }
}

TEST(StatusFeed, DropsATickWithAMissingPartAndCountsIt) {
  Feed sut({1, 300}, 1);
  for (const std::uint64_t tick : {5U, 6U, 7U}) {
    sut.on_frame(frame(tick, {1}));
    if (tick != 6) sut.on_frame(frame(tick, {300}));
  }
  EXPECT_EQ(sut.take()->tick, 5U);
  const auto after = sut.take();
  EXPECT_EQ(after->tick, 7U);
  EXPECT_EQ(after->missed, 1U);
}

TEST(StatusFeed, CountsSamplesOfAThinnedStream) {
  Feed sut({1}, 10);
  for (const std::uint64_t tick : {10U, 20U, 50U}) sut.on_frame(frame(tick, {1}));
  EXPECT_EQ(sut.take()->missed, 0U);
  EXPECT_EQ(sut.take()->missed, 0U);
  EXPECT_EQ(sut.take()->missed, 2U);
}

msg::StatusFrame frame_after_jumps(std::uint64_t tick, std::uint64_t skipped) {
  msg::StatusFrame message = frame(tick, {1});
  message.skipped_ticks = static_cast<std::uint32_t>(skipped);
  return message;
}

// After 5 the number jumps over 9,000 ticks. Of the ticks run after that, 9,006 is lost.
TEST(StatusFeed, CountsTheTicksThatTheNumberJumpedOverApartFromLostOnes) {
  Feed sut({1}, 1);
  for (const std::uint64_t tick : {4U, 5U}) sut.on_frame(frame_after_jumps(tick, 70));
  for (const std::uint64_t tick : {9'007U, 9'008U}) {
    sut.on_frame(frame_after_jumps(tick, 9'070));
  }
  EXPECT_EQ(sut.take()->skipped, 0U) << "what was before the first sample is not its gap";
  EXPECT_EQ(sut.take()->axes[0].skipped, 0U);
  const auto after = sut.take();
  EXPECT_EQ(after->missed, 1U);
  EXPECT_EQ(after->skipped, 9'000U);
  EXPECT_EQ(after->axes[0].driven_tick(), 7U);
  const auto next = sut.take();
  EXPECT_EQ(next->skipped, 0U);
  EXPECT_EQ(next->axes[0].driven_tick(), 8U) << "drive time goes on from there";
}

// The tick number jumps from 1970 to 2023 in milliseconds, although the frame's count has only 32
// bits.
TEST(StatusFeed, CountsAJumpOfDecades) {
  constexpr std::uint64_t kJump = 1'700'000'000'000;
  Feed sut({1}, 10);
  sut.on_frame(frame_after_jumps(100, 0));
  sut.on_frame(frame_after_jumps(kJump + 130, kJump));
  ASSERT_TRUE(sut.take().has_value());
  const auto after = sut.take();
  EXPECT_EQ(after->skipped, kJump);
  EXPECT_EQ(after->missed, 2U) << "those of the ticks 110 and 120";
}

TEST(StatusFeed, IgnoresOtherBenchesOtherRunsAndOlderTicks) {
  Feed sut({1}, 1);
  msg::StatusFrame other = frame(5, {1});
  other.bench = 2;
  sut.on_frame(other);
  msg::StatusFrame restarted = frame(5, {1});
  restarted.incarnation = 11;
  sut.on_frame(restarted);
  EXPECT_FALSE(sut.take().has_value());
  sut.on_frame(frame(5, {1}));
  sut.on_frame(frame(4, {1}));
  EXPECT_EQ(sut.take()->tick, 5U);
  EXPECT_FALSE(sut.take().has_value());
}

TEST(StatusFeed, KeepsTheNewestSamplesWhenNoneIsTaken) {
  Feed sut({1}, 1);
  sut.on_frame(frame(1, {1}));
  EXPECT_EQ(sut.take()->tick, 1U);
  for (std::uint64_t tick = 2; tick <= 10'000; ++tick) sut.on_frame(frame(tick, {1}));
  const auto oldest = sut.take();
  EXPECT_EQ(oldest->tick, 10'000U - 4096 + 1);
  EXPECT_EQ(oldest->missed, oldest->tick - 2);
}

TEST(StatusFeed, AcceptsARepeatedTick) {
  Feed sut({1, 2}, 1);
  sut.on_frame(frame(5, {1, 2}));
  sut.on_frame(frame(5, {1, 2}));
  EXPECT_EQ(sut.take()->axes.size(), 2U);
  EXPECT_EQ(sut.take()->axes.size(), 2U);
}

TEST(StatusFeed, SurvivesADuplicateAxisInAFrame) {
  Feed sut({1, 2}, 1);
  sut.on_frame(frame(5, {1, 1}));
  EXPECT_FALSE(sut.take().has_value());
}

}  // namespace
}  // namespace vdrive::client
