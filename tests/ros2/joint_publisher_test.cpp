// SPDX-License-Identifier: Apache-2.0
#include "joint_publisher.hpp"

#include <gtest/gtest.h>

namespace vdrive::ros2 {
namespace {

using namespace std::chrono_literals;

constexpr StateTimes::Clock::time_point kTimesBegin{1h};

/// A bench with ticks of 1 ms; its states are published at 100 Hz.
struct Timed {
  client::BenchInfo bench{};
  StateTimes times{100.0};

  explicit Timed(ClockMode clock) {
    bench.number = 1;
    bench.incarnation = 5;
    bench.clock_mode = clock;
  }

  bool take(std::uint64_t tick, std::chrono::milliseconds time) {
    return times.take(bench, tick, kTimesBegin + time);
  }
};

TEST(StateTimes, PublishTheFirstStateOfEachRunAtOnce) {
  Timed timed(ClockMode::realtime);
  EXPECT_TRUE(timed.take(7, 0ms));
  EXPECT_FALSE(timed.take(8, 1ms));
  timed.bench.incarnation = 6;
  EXPECT_TRUE(timed.take(7, 2ms)) << "also with the number of a tick that was published";
}

TEST(StateTimes, KeepTheRateInWallTimeWithoutDrift) {
  Timed timed(ClockMode::realtime);
  EXPECT_TRUE(timed.take(1, 0ms));
  EXPECT_FALSE(timed.take(9, 9ms));
  EXPECT_TRUE(timed.take(14, 14ms)) << "4 ms late";
  EXPECT_TRUE(timed.take(20, 20ms)) << "due as if the one before had been in time";
  EXPECT_TRUE(timed.take(55, 55ms));
  EXPECT_FALSE(timed.take(64, 64ms)) << "more than a period late: no burst makes up for it";
  EXPECT_TRUE(timed.take(65, 65ms));
}

TEST(StateTimes, PublishNoTickTwiceWithinASecond) {
  Timed timed(ClockMode::freerun);
  EXPECT_TRUE(timed.take(1, 0ms));
  EXPECT_FALSE(timed.take(1, 50ms));
  EXPECT_TRUE(timed.take(2, 50ms));
}

TEST(StateTimes, RepeatTheStateOnceASecondWhileNoTickPasses) {
  for (const ClockMode clock : {ClockMode::lockstep, ClockMode::freerun, ClockMode::realtime}) {
    Timed timed(clock);
    EXPECT_TRUE(timed.take(1, 0ms));
    EXPECT_FALSE(timed.take(1, 999ms));
    EXPECT_TRUE(timed.take(1, 1'000ms)) << "a node that came meanwhile sees the joints";
    EXPECT_FALSE(timed.take(1, 1'999ms));
    EXPECT_TRUE(timed.take(1, 2'000ms));
    EXPECT_TRUE(timed.take(11, 2'010ms)) << "the clock goes on";
  }
}

TEST(StateTimes, KeepTheRateInDriveTimeInLockStep) {
  Timed timed(ClockMode::lockstep);
  EXPECT_TRUE(timed.take(1, 0ms));
  EXPECT_FALSE(timed.take(10, 0ms));
  EXPECT_TRUE(timed.take(11, 0ms)) << "10 ticks of 1 ms";
  EXPECT_TRUE(timed.take(3, 0ms)) << "the bench counts from a lower number";
}

TEST(StateTimes, PublishTheTickInWhichAStepEnds) {
  Timed timed(ClockMode::lockstep);
  EXPECT_TRUE(timed.take(1, 0ms));
  EXPECT_FALSE(timed.take(2, 5ms));
  EXPECT_FALSE(timed.take(3, 20ms)) << "the step goes on";
  EXPECT_FALSE(timed.take(3, 39ms));
  EXPECT_TRUE(timed.take(3, 40ms)) << "no tick for 20 ms";
}

TEST(StateTimes, AreAskedAgainAtThePeriodOrTenMillisecondsAtTheLatest) {
  EXPECT_EQ(StateTimes(1'000.0).next(kTimesBegin), kTimesBegin + 1ms);
  EXPECT_EQ(StateTimes(1.0).next(kTimesBegin), kTimesBegin + 10ms);
  Timed timed(ClockMode::realtime);
  EXPECT_TRUE(timed.take(1, 0ms));
  EXPECT_EQ(timed.times.next(kTimesBegin + 7ms), kTimesBegin + 10ms) << "the next state is due";
}

}  // namespace
}  // namespace vdrive::ros2
