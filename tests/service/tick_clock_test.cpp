// SPDX-License-Identifier: Apache-2.0
#include "clock/tick_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = 1ms;
constexpr std::chrono::nanoseconds kWall = 1'700'000'000s;  // a multiple of the tick
constexpr std::chrono::nanoseconds kMonotonic = 5'000s;
constexpr std::uint64_t kTickAtWall = 1'700'000'000'000;

TEST(TickClock, NumbersTicksByTheWallClock) {
  const TickClock clock(kPeriod, 1.0, {kMonotonic, kWall + 300us});
  EXPECT_EQ(clock.next_tick(), kTickAtWall + 1);
  EXPECT_EQ(clock.deadline(), kMonotonic + 700us);
}

TEST(TickClock, GivesTheSameNumberAtTheSameTimeToTwoBenches) {
  TickClock early(kPeriod, 1.0, {kMonotonic, kWall});
  for (int tick = 0; tick < 1'000; ++tick) {
    early.advance({early.deadline(), kWall + (early.deadline() - kMonotonic)});
  }
  const TickClock late(kPeriod, 1.0, {kMonotonic + 1'000'400us, kWall + 1'000'400us});
  EXPECT_EQ(early.next_tick(), late.next_tick());
  EXPECT_NEAR(static_cast<double>((early.deadline() - late.deadline()).count()), 0.0, 2'000.0);
}

TEST(TickClock, SteersTowardsTheWallClockByAtMost500Ppm) {
  TickClock clock(kPeriod, 1.0, {kMonotonic, kWall});
  auto before = clock.deadline();
  // The wall clock is set forward by half a second. The deadlines approach it slowly instead of
  // jumping.
  for (int tick = 0; tick < 2'000; ++tick) {
    clock.advance({before, kWall + (before - kMonotonic) + 500ms});
    const auto distance = clock.deadline() - before;
    ASSERT_GE(distance, 999'499ns);
    ASSERT_LE(distance, 1'000'501ns);
    before = clock.deadline();
  }
  // 2,000 ticks at 500 ppm: one tick gained.
  const auto due = kMonotonic + 2'001 * kPeriod;
  EXPECT_NEAR(static_cast<double>((due - clock.deadline()).count()), 1e6, 2e3);
}

TEST(TickClock, ConvergesToTheWallClock) {
  TickClock clock(kPeriod, 1.0, {kMonotonic, kWall});
  constexpr auto kOffset = 300us;  // the wall clock is ahead by this from now on
  for (int tick = 0; tick < 20'000; ++tick) {
    clock.advance({clock.deadline(), kWall + (clock.deadline() - kMonotonic) + kOffset});
  }
  const auto wall = kWall + (clock.deadline() - kMonotonic) + kOffset;
  const auto begin =
      std::chrono::nanoseconds(kPeriod) * static_cast<std::int64_t>(clock.next_tick());
  EXPECT_NEAR(static_cast<double>((wall - begin).count()), 0.0, 1e3);
}

/// Runs `ticks` ticks; in each, the wall clock is ahead by `ahead(tick)`. @return the steps
/// detected.
std::vector<WallStep> run(TickClock& clock, int ticks,
                          const std::function<std::chrono::nanoseconds(int)>& ahead) {
  std::vector<WallStep> steps;
  for (int tick = 0; tick < ticks; ++tick) {
    const auto now = clock.deadline();
    if (const auto step = clock.advance({now, kWall + (now - kMonotonic) + ahead(tick)})) {
      steps.push_back(*step);
    }
  }
  return steps;
}

TEST(TickClock, DetectsAStepAboveTenMillisecondsOnce) {
  for (const auto offset : {10'100us, -10'100us, 3'600'000'000us, -3'600'000'000us}) {
    TickClock clock(kPeriod, 1.0, {kMonotonic, kWall});
    const auto steps = run(clock, 20'000, [&](int tick) {
      return tick < 10 ? 0us : offset;
    });
    ASSERT_EQ(steps.size(), 1U) << offset.count();
    // The two readings before the detection steer by 0.5 us each.
    EXPECT_NEAR(static_cast<double>(steps[0].offset.count()), 1e3 * double(offset.count()), 2e3);
    EXPECT_EQ(steps[0].jumped, 0U);
    EXPECT_EQ(clock.next_tick(), kTickAtWall + 20'001) << "no number is left out or comes twice";
  }
}

TEST(TickClock, IgnoresSmallStepsDriftAndASingleWrongReading) {
  TickClock small(kPeriod, 1.0, {kMonotonic, kWall});
  EXPECT_TRUE(run(small, 1'000, [](int) {
                return 9'900us;
              }).empty());
  TickClock drift(kPeriod, 1.0, {kMonotonic, kWall});
  // 900 ppm for 100 s: 500 ppm are steered away, the other 400 ppm add up to 40 ms.
  EXPECT_TRUE(run(drift, 100'000, [](int tick) {
                return 900ns * tick;
              }).empty());
  EXPECT_NEAR(static_cast<double>(drift.offset().count()), 40e6, 1e6);
  TickClock wrong(kPeriod, 1.0, {kMonotonic, kWall}, WallStepPolicy::jump);
  EXPECT_TRUE(run(wrong, 1'000, [](int tick) {
                return tick % 10 < 2 ? 1'000'000us : 0us;  // twice in a row
              }).empty());
}

TEST(TickClock, DetectsASecondStepDuringCorrectionOfTheFirst) {
  TickClock clock(kPeriod, 1.0, {kMonotonic, kWall});
  const auto steps = run(clock, 2'000, [](int tick) {
    return tick < 1'000 ? 10s : 0s;
  });
  ASSERT_EQ(steps.size(), 2U);
  // After 1,000 ticks at 500 ppm the clock is half a millisecond too far ahead.
  EXPECT_NEAR(static_cast<double>(steps[1].offset.count()), -0.5e6, 1e4);
}

// Of 10.0004 s, 10,000 ticks are skipped and the rest is steered away.
TEST(TickClock, JumpsToTheWallClockWhereConfigured) {
  TickClock clock(kPeriod, 1.0, {kMonotonic, kWall}, WallStepPolicy::jump);
  const auto steps = run(clock, 1'000, [](int tick) {
    return tick < 10 ? 0us : 10'000'400us;
  });
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_EQ(steps[0].jumped, 10'000U);
  EXPECT_EQ(clock.next_tick(), kTickAtWall + 1'001 + 10'000);
  EXPECT_NEAR(static_cast<double>(clock.offset().count()), 0.0, 1e5);
}

TEST(TickClock, NeverJumpsBack) {
  TickClock clock(kPeriod, 1.0, {kMonotonic, kWall}, WallStepPolicy::jump);
  const auto steps = run(clock, 1'000, [](int tick) {
    return tick < 10 ? 0s : -10s;
  });
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_EQ(steps[0].jumped, 0U);
  EXPECT_EQ(clock.next_tick(), kTickAtWall + 1'001);
}

TEST(TickClock, DetectsNoStepAtAnotherRate) {
  TickClock clock(kPeriod, 2.0, {kMonotonic, kWall}, WallStepPolicy::jump);
  EXPECT_TRUE(run(clock, 100, [](int) {
                return 10s;
              }).empty());
  EXPECT_EQ(clock.offset(), 0ns);
}

TEST(TickClock, CatchesUpABacklogOfAHundredTicks) {
  TickClock clock(kPeriod, 1.0, {kMonotonic, kWall});
  EXPECT_EQ(clock.skip_backlog(clock.deadline() + 100ms), 0U);
  EXPECT_EQ(clock.next_tick(), kTickAtWall + 1);
}

TEST(TickClock, JumpsOverALargerBacklog) {
  TickClock clock(kPeriod, 1.0, {kMonotonic, kWall});
  const auto now = clock.deadline() + 5'000'500us;
  EXPECT_EQ(clock.skip_backlog(now), 5'000U);
  EXPECT_EQ(clock.next_tick(), kTickAtWall + 5'001);
  EXPECT_EQ(now - clock.deadline(), 500us);
}

TEST(TickClock, JumpsOverAHundredAndOneTicks) {
  TickClock clock(kPeriod, 1.0, {kMonotonic, kWall});
  EXPECT_EQ(clock.skip_backlog(clock.deadline() + 101ms), 101U);
}

// Half a tick is left when the rate changes; at rate 2 that takes a quarter of a millisecond.
TEST(TickClock, KeepsTheDriveTimeUntilTheNextTickWhenTheRateChanges) {
  TickClock clock(kPeriod, 1.0, {kMonotonic, kWall});
  const Instant now{kMonotonic + 500us, kWall + 500us};
  clock.set_rate(2.0, now);
  EXPECT_EQ(clock.next_tick(), kTickAtWall + 1);
  EXPECT_EQ(clock.deadline(), now.monotonic + 250us);
  clock.advance({clock.deadline(), kWall + 750us});
  EXPECT_EQ(clock.deadline(), now.monotonic + 750us);
}

TEST(TickClock, ContinuesAfterAPauseWithTheNextNumberAndANewReference) {
  const Instant resumed{kMonotonic + 60s, kWall + 60s};
  TickClock clock(kPeriod, 1.0, resumed, kTickAtWall + 8);
  EXPECT_EQ(clock.next_tick(), kTickAtWall + 8) << "a minute of pause is no tick";
  EXPECT_EQ(clock.deadline(), resumed.monotonic + 1ms);
  for (int tick = 0; tick < 1'000; ++tick) {  // both clocks agree: nothing to steer
    const auto before = clock.deadline();
    clock.advance({before, kWall + (before - kMonotonic)});
    ASSERT_EQ(clock.deadline() - before, 1ms);
  }
  EXPECT_EQ(clock.next_tick(), kTickAtWall + 1'008);
}

TEST(TickClock, IsCorrectedAgainAtRateOneFromItsLastOffset) {
  TickClock clock(kPeriod, 10.0, {kMonotonic, kWall});
  for (int tick = 0; tick < 100; ++tick) {
    clock.advance({clock.deadline(), kWall + (clock.deadline() - kMonotonic)});
  }
  clock.set_rate(1.0, {clock.deadline(), kWall + (clock.deadline() - kMonotonic)});
  // Without a new reference the number would be 90 ticks ahead of the wall clock.
  const auto before = clock.deadline();
  clock.advance({before, kWall + (before - kMonotonic)});
  EXPECT_EQ(clock.deadline() - before, 1ms);
}

TEST(TickClock, ScalesTheDistanceByTheRate) {
  TickClock clock(kPeriod, 4.0, {kMonotonic, kWall});
  const auto first = clock.deadline();
  clock.advance({first, kWall + 7s});  // the clock is steered only at rate 1
  EXPECT_EQ(clock.deadline() - first, 250us);
  EXPECT_EQ(clock.next_tick(), kTickAtWall + 2);
}

}  // namespace
}  // namespace vdrive::service
