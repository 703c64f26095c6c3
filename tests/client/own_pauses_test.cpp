// SPDX-License-Identifier: Apache-2.0
// The times when a program did not run, and that they are no silence of a bench.
#include "presence/own_pauses.hpp"

#include "bench_messages.hpp"
#include "presence/directory.hpp"

#include <gtest/gtest.h>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;

constexpr auto kBegin = OwnPauses::Clock::time_point(1h);

TEST(OwnPauses, AProgramThatNotesTheTimeInItsPeriodDoesNotPause) {
  OwnPauses sut(kBegin);
  for (auto now = kBegin; now < kBegin + 10s; now += OwnPauses::kPeriod) {
    EXPECT_EQ(sut.note(now), 0ms);
  }
  EXPECT_EQ(sut.total(), 0ms);
}

TEST(OwnPauses, ANoteThatIsLateByLessThanTheLongestGapIsNoPause) {
  OwnPauses sut(kBegin);
  EXPECT_EQ(sut.note(kBegin + OwnPauses::kLongestGap), 0ms);
}

TEST(OwnPauses, ATimeWithoutANoteIsAPauseButForOnePeriod) {
  OwnPauses sut(kBegin);
  EXPECT_EQ(sut.note(kBegin + 4s), 4s - OwnPauses::kPeriod);
  EXPECT_EQ(sut.note(kBegin + 4s), 0ms) << "each pause once";
  EXPECT_EQ(sut.note(kBegin + 5s), 1s - OwnPauses::kPeriod);
  EXPECT_EQ(sut.total(), 5s - 2 * OwnPauses::kPeriod);
}

TEST(OwnPauses, ANoteOfAnEarlierTimeChangesNothing) {
  OwnPauses sut(kBegin);
  EXPECT_EQ(sut.note(kBegin - 1s), 0ms);
  EXPECT_EQ(sut.note(kBegin + 50ms), 0ms);
}

TEST(OwnPauses, ADiscountedPauseMakesNoSampleOlder) {
  Directory directory;
  directory.on_description(description(1, 10), kSource, kBegin);
  directory.on_state(state(1, 10), kBegin);
  OwnPauses sut(kBegin);
  const auto after = kBegin + 4s;
  EXPECT_FALSE(directory.is_alive({1, 10}, 1500ms, after));
  directory.discount(sut.note(after));
  EXPECT_TRUE(directory.is_alive({1, 10}, 1500ms, after));
  EXPECT_TRUE(directory.find(1, after)) << "it is there";
  EXPECT_EQ(directory.age({1, 10}, after), OwnPauses::kPeriod);
  EXPECT_FALSE(directory.is_alive({1, 10}, 1500ms, after + 2s))
      << "a silence while the program runs";
}

}  // namespace
}  // namespace vdrive::client
