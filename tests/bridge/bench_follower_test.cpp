// SPDX-License-Identifier: Apache-2.0
#include "bench_follower.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>

namespace vdrive::bridge {
namespace {

using namespace std::chrono_literals;
using client::Observation;
using client::Outcome;
using client::Result;

constexpr BenchFollower::Clock::time_point kBegin{1h};

/// A bench whose samples the test controls.
struct BenchDouble {
  std::deque<std::uint64_t> ticks{};  ///< received and waiting
  bool is_there = true;
  int openings = 0;

  BenchFollower::Open open() {
    return [this]() -> Result<BenchFollower::Next> {
      ++openings;
      if (!is_there) return Outcome::not_found("no bench");
      return BenchFollower::Next([this](std::chrono::milliseconds) -> Result<Observation> {
        if (!is_there) return Outcome::lost("silent");
        if (ticks.empty()) return Outcome::timed_out("no sample");
        const std::uint64_t tick = ticks.front();
        ticks.pop_front();
        Observation sample;
        sample.tick = tick;
        return sample;
      });
    };
  }
};

TEST(BenchFollower, GivesSamplesInTheirOrder) {
  BenchDouble bench{.ticks = {4, 5}};
  BenchFollower follower(bench.open());
  EXPECT_TRUE(follower.open(kBegin));
  EXPECT_FALSE(follower.open(kBegin)) << "it follows already";
  EXPECT_EQ(follower.next(10ms)->tick, 4U);
  EXPECT_EQ(follower.next(10ms)->tick, 5U);
  EXPECT_FALSE(follower.next(10ms));
  EXPECT_TRUE(follower.is_open()) << "no sample came in time: that is no loss";
}

TEST(BenchFollower, GivesTheNewestOfTheSamplesThatHaveArrived) {
  BenchDouble bench{.ticks = {4, 5, 6}};
  BenchFollower follower(bench.open());
  (void)follower.open(kBegin);
  EXPECT_EQ(follower.newest(10ms)->tick, 6U);
  EXPECT_FALSE(follower.newest(10ms));
}

TEST(BenchFollower, EndsWithTheBenchAndBeginsAgain) {
  BenchDouble bench{};
  BenchFollower follower(bench.open());
  (void)follower.open(kBegin);
  bench.is_there = false;
  EXPECT_FALSE(follower.next(10ms));
  EXPECT_FALSE(follower.is_open());
  bench.is_there = true;
  EXPECT_TRUE(follower.open(kBegin)) << "a loss is no failed attempt";
}

TEST(BenchFollower, WaitsAfterAFailureBeforeItTriesAgain) {
  BenchDouble bench{.is_there = false};
  BenchFollower follower(bench.open());
  EXPECT_FALSE(follower.open(kBegin));
  bench.is_there = true;
  EXPECT_FALSE(follower.open(kBegin + BenchFollower::kRetry - 1ms));
  EXPECT_EQ(bench.openings, 1);
  EXPECT_TRUE(follower.open(kBegin + BenchFollower::kRetry));
}

}  // namespace
}  // namespace vdrive::bridge
