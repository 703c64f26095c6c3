// SPDX-License-Identifier: Apache-2.0
// Presence as shown by the age of samples. Presence on a local bus is tested in local_bus_test.
#include "vdrive/wire/presence_by_age.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::wire {
namespace {

using namespace std::chrono_literals;
using testing::SizeIs;

constexpr Source kSource{{1, 2, 3}};

class PresenceByAgeTest : public testing::Test {
 protected:
  static constexpr auto kBegin = Presence::Clock::time_point(1h);

  PresenceByAgeTest() { EXPECT_EQ(sut_.own_pauses(kBegin), 0ms); }

  PresenceByAge sut_{[](std::string_view beginning) {
    return std::vector<OtherParticipant>{{.name = std::string(beginning) + "1", .source = kSource}};
  }};
};

TEST_F(PresenceByAgeTest, KnowsThoseThatHaveAnnouncedThemselvesAndNobodyForCertain) {
  ASSERT_THAT(sut_.others("vdrived "), SizeIs(1));
  EXPECT_EQ(sut_.others("vdrived ").front().name, "vdrived 1");
  EXPECT_FALSE(sut_.is_certain(kSource)) << "it may have died";
  EXPECT_TRUE(sut_.may_miss_some());
  EXPECT_TRUE(sut_.may_have_double());
  EXPECT_TRUE(sut_.may_return());
}

TEST_F(PresenceByAgeTest, CountsSilenceFromTheNewestSample) {
  EXPECT_EQ(sut_.silence(kSource, std::nullopt, kBegin), std::nullopt);
  EXPECT_EQ(sut_.silence(kSource, kBegin, kBegin), 0ms);
  EXPECT_EQ(sut_.silence(kSource, kBegin, kBegin + 40ms), 40ms);
  EXPECT_EQ(sut_.silence({}, kBegin, kBegin + 2h), 2h) << "whoever it is";
}

TEST_F(PresenceByAgeTest, AProgramThatKeepsItsPulseDoesNotPause) {
  ASSERT_EQ(sut_.pulse(), PresenceByAge::kPulse);
  for (auto now = kBegin; now < kBegin + 10s; now += *sut_.pulse()) {
    EXPECT_EQ(sut_.own_pauses(now), 0ms);
  }
}

TEST_F(PresenceByAgeTest, APulseThatIsLateByLessThanTheLongestGapIsNoPause) {
  EXPECT_EQ(sut_.own_pauses(kBegin + PresenceByAge::kLongestGap), 0ms);
}

TEST_F(PresenceByAgeTest, ATimeWithoutAPulseIsAPauseExceptForOnePeriod) {
  EXPECT_EQ(sut_.own_pauses(kBegin + 4s), 4s - PresenceByAge::kPulse);
  EXPECT_EQ(sut_.own_pauses(kBegin + 4s), 4s - PresenceByAge::kPulse) << "each pause once";
  EXPECT_EQ(sut_.own_pauses(kBegin + 5s), 5s - 2 * PresenceByAge::kPulse);
}

TEST_F(PresenceByAgeTest, AnEarlierTimeThanTheNewestChangesNothing) {
  EXPECT_EQ(sut_.own_pauses(kBegin - 1s), 0ms);
  EXPECT_EQ(sut_.own_pauses(kBegin + 50ms), 0ms);
}

TEST_F(PresenceByAgeTest, APauseOfThisProgramIsNoSilence) {
  const auto before = sut_.running_time(kBegin);
  const auto after = sut_.running_time(kBegin + 4s);
  EXPECT_EQ(sut_.silence(kSource, before, after), PresenceByAge::kPulse);
  const auto later = sut_.running_time(kBegin + 4s + PresenceByAge::kLongestGap);
  EXPECT_EQ(later - after, PresenceByAge::kLongestGap) << "while it runs, time passes";
}

// Others remove a silent program after 2.5 s.
TEST_F(PresenceByAgeTest, AllowsOthersTheTimeToFindAProgramThatTheyHaveRemoved) {
  EXPECT_FALSE(sut_.is_excused(sut_.running_time(kBegin + 2s))) << "they still know it";
  const auto found = sut_.running_time(kBegin + 5s);
  EXPECT_TRUE(sut_.is_excused(found));
  EXPECT_TRUE(sut_.is_excused(found + PresenceByAge::kTimeToBeFoundAgain - 1ms));
  EXPECT_FALSE(sut_.is_excused(found + PresenceByAge::kTimeToBeFoundAgain));
}

}  // namespace
}  // namespace vdrive::wire
