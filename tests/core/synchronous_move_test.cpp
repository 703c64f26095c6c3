// SPDX-License-Identifier: Apache-2.0
//
// Synchronous move 5E10h: axes that start on one tick with the same times keep the proportions of
// their displacements and arrive on one tick.
#include "support/effort.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace vdrive {
namespace {

using std::chrono::microseconds;

constexpr ObjectAddress kDuration{0x5E10, 1};
constexpr ObjectAddress kAccelerationTime{0x5E10, 2};
constexpr ObjectAddress kDecelerationTime{0x5E10, 3};
constexpr ObjectAddress kJerkTime{0x5E10, 4};
constexpr std::int64_t kUnlimited = 4294967040;

struct Times {
  std::uint32_t duration_us;
  std::uint32_t acceleration_us;
  std::uint32_t deceleration_us;
};

/// Enabled axes in profile position mode without torque or speed limits worth mentioning.
class Group {
 public:
  explicit Group(std::size_t count, microseconds period = microseconds{1000})
      : bank_(std::vector<AxisConfiguration>(count), period) {
    for (std::size_t axis = 0; axis < count; ++axis) {
      write(axis, {0x6065, 0}, 4294967295);  // only the demand is checked
      write(axis, {0x607F, 0}, 4294967295);
      write(axis, {0x6080, 0}, 4294967295);
      write(axis, {0x6060, 0}, 1);
      write(axis, {0x6040, 0}, 0x0F);
    }
    bank_.step();
  }

  void write(std::size_t axis, ObjectAddress object, std::int64_t value) {
    ASSERT_EQ(bank_.write(axis, object, value), AbortCode::none) << std::hex << object.index;
  }

  void set_times(std::size_t axis, const Times& times) {
    write(axis, kDuration, times.duration_us);
    write(axis, kAccelerationTime, times.acceleration_us);
    write(axis, kDecelerationTime, times.deceleration_us);
  }

  void start(const std::vector<std::int32_t>& targets, const Times& times,
             std::int64_t word = 0x1F) {
    for (std::size_t axis = 0; axis < targets.size(); ++axis) {
      set_times(axis, times);
      write(axis, {0x607A, 0}, targets[axis]);
      write(axis, {0x6040, 0}, 0x0F);
      write(axis, {0x6040, 0}, word);
    }
  }

  void command(std::int64_t controlword) {
    for (std::size_t axis = 0; axis < bank_.size(); ++axis) {
      write(axis, {0x6040, 0}, controlword);
    }
  }

  [[nodiscard]] std::int32_t demand(std::size_t axis) const {
    return bank_.status(axis).position_demand_value;
  }

  [[nodiscard]] bool shows(std::size_t axis, std::uint16_t bits) const {
    return (bank_.status(axis).ds402_statusword & bits) == bits;
  }

  AxisBank& bank() { return bank_; }

 private:
  AxisBank bank_;
};

/// Largest distance of the demands from the straight line between starts and targets, on the axis
/// that has the longest way taken as the measure.
double deviation(const Group& group, const std::vector<std::int32_t>& starts,
                 const std::vector<std::int32_t>& targets) {
  std::size_t longest = 0;
  const auto way = [&](std::size_t axis) {
    return static_cast<double>(targets[axis]) - starts[axis];
  };
  for (std::size_t axis = 1; axis < starts.size(); ++axis) {
    longest = std::abs(way(axis)) > std::abs(way(longest)) ? axis : longest;
  }
  if (way(longest) == 0.0) return 0.0;
  const double done = (static_cast<double>(group.demand(longest)) - starts[longest]) / way(longest);
  double worst = 0.0;
  for (std::size_t axis = 0; axis < starts.size(); ++axis) {
    const double on_line = starts[axis] + done * way(axis);
    worst = std::max(worst, std::abs(group.demand(axis) - on_line));
  }
  return worst;
}

/// Shortest triangle over `way` within 60C5h: way = a·(T/2)², some slack for the rounding to ticks.
std::uint32_t shortest_us(double way) {
  return static_cast<std::uint32_t>(2.0e6 * std::sqrt(way / static_cast<double>(kUnlimited))) +
         4000U;
}

#ifdef NDEBUG
const int kMovesOfABank = test::number_of<int>({.usual = 60, .full = 250, .nightly = 2'500});
#else
constexpr int kMovesOfABank = 4;
#endif

TEST(SynchronousMove, KeepsItsStraightLineWithinAUnitAndArrivesInOneTick) {
  std::mt19937_64 random(5);
  const auto uniform = [&](std::int64_t low, std::int64_t high) {
    return std::uniform_int_distribution<std::int64_t>(low, high)(random);
  };
  for (int bank = 0; bank < 40; ++bank) {
    const auto count = static_cast<std::size_t>(uniform(2, 64));
    Group group(count);
    for (int move = 0; move < kMovesOfABank; ++move) {
      SCOPED_TRACE("bank " + std::to_string(bank) + " of " + std::to_string(count) +
                   " axes, move " + std::to_string(move));
      // Ways of every magnitude from 0 to 1e9 units, positions within ±1e9.
      const auto reach = static_cast<std::int64_t>(
          std::pow(10.0, std::uniform_real_distribution<double>(0.0, 9.0)(random)));
      std::vector<std::int32_t> starts(count);
      std::vector<std::int32_t> targets(count);
      for (std::size_t axis = 0; axis < count; ++axis) {
        starts[axis] = group.demand(axis);
        const std::int64_t towards_zero = starts[axis] > 0 ? -1 : 1;
        targets[axis] = static_cast<std::int32_t>(starts[axis] + towards_zero * uniform(0, reach));
      }
      const std::uint32_t triangle = shortest_us(static_cast<double>(reach));
      const auto extra = static_cast<std::uint32_t>(uniform(0, 30'000));
      const Times times{triangle + extra, triangle / 2, triangle / 2};
      group.start(targets, times, 0x3F);  // the axes themselves may lag behind the one before

      // At rest again in the tick that completes the duration, all of them and not before.
      const std::uint32_t ticks = (times.duration_us + 999) / 1000;
      for (std::uint32_t tick = 1; tick < ticks; ++tick) {
        group.bank().step();
        ASSERT_LE(deviation(group, starts, targets), 1.0) << "tick " << tick;
      }
      group.bank().step();
      for (std::size_t axis = 0; axis < count; ++axis) {
        ASSERT_EQ(group.demand(axis), targets[axis]) << "axis " << axis;
        ASSERT_EQ(group.bank().status(axis).velocity_demand_value, 0) << "axis " << axis;
      }
    }
  }
}

/// Two axes, 3:1, whose bit 10 does not wait for the window time.
class TwoAxes : public testing::Test {
 protected:
  TwoAxes() {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      group.write(axis, {0x6067, 0}, 4294967295);
    }
  }

  Group group{2};
};

TEST_F(TwoAxes, AnAxisWithoutDistanceMovesAsLongAsTheOther) {
  group.start({30'000, 0}, {400'000, 100'000, 100'000});
  for (int tick = 1; tick < 400; ++tick) {
    group.bank().step();
    ASSERT_FALSE(group.shows(1, Statusword::kTargetReached)) << tick;
  }
  group.bank().step();
  EXPECT_TRUE(group.shows(0, Statusword::kTargetReached));
  EXPECT_TRUE(group.shows(1, Statusword::kTargetReached));
}

TEST_F(TwoAxes, HaltAndResumeStayOnTheStraightLine) {
  const std::vector<std::int32_t> starts{0, 0};
  const std::vector<std::int32_t> targets{90'000, -30'000};
  group.start(targets, {900'000, 200'000, 300'000});
  for (int tick = 0; tick < 350; ++tick) group.bank().step();
  group.command(0x010F);
  for (int tick = 0; tick < 400; ++tick) {
    group.bank().step();
    ASSERT_LE(deviation(group, starts, targets), 1.0) << tick;
  }
  ASSERT_EQ(group.bank().status(0).velocity_demand_value, 0);
  ASSERT_NE(group.demand(0), targets[0]);
  group.command(0x000F);
  for (int tick = 0; tick < 900; ++tick) {
    group.bank().step();
    ASSERT_LE(deviation(group, starts, targets), 1.0) << tick;
  }
  EXPECT_EQ(group.demand(0), targets[0]);
  EXPECT_EQ(group.demand(1), targets[1]);
}

TEST_F(TwoAxes, AnAxisWithoutDistanceHaltsAndEndsWithTheOther) {
  group.start({90'000, 0}, {900'000, 200'000, 300'000});
  for (int tick = 0; tick < 350; ++tick) group.bank().step();
  group.command(0x010F);
  for (int tick = 0; tick < 400; ++tick) {
    group.bank().step();
    ASSERT_EQ(group.demand(1), 0) << tick;
  }
  EXPECT_TRUE(group.shows(0, Statusword::kTargetReached)) << "at standstill";
  EXPECT_TRUE(group.shows(1, Statusword::kTargetReached));
  group.command(0x000F);
  for (int tick = 0; tick < 900; ++tick) {
    group.bank().step();
    ASSERT_EQ(group.demand(1), 0) << tick;
  }
  EXPECT_EQ(group.demand(0), 90'000);
  EXPECT_TRUE(group.shows(1, Statusword::kTargetReached));
}

TEST_F(TwoAxes, TheSpeedComesFromTheTimesAndNotFrom6081h) {
  group.write(0, {0x6081, 0}, 1);
  // 60000 UU in 700 ms with ramps of 100 ms: 60000 / (0.7 - 0.1) s = 100000 UU/s.
  group.start({60'000, 20'000}, {700'000, 100'000, 100'000});
  for (int tick = 0; tick < 300; ++tick) group.bank().step();
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 100'000);
  EXPECT_EQ(group.bank().status(1).velocity_demand_value, 33'333);
}

TEST_F(TwoAxes, TheTimesAreLatchedWithTheSetPoint) {
  group.start({60'000, 20'000}, {700'000, 100'000, 100'000});
  group.bank().step();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    group.set_times(axis, {100, 50, 50});
  }
  for (int tick = 1; tick < 700; ++tick) group.bank().step();
  EXPECT_EQ(group.demand(0), 60'000);
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 0);
}

/// A set-point that cannot be kept is not acknowledged, counted, and moves nothing.
TEST_F(TwoAxes, TimesBeyondTheLimitsAreNotAccepted) {
  struct Row {
    const char* what;
    ObjectAddress limit;
    std::int64_t value;
    Times times;
  };

  // 60000 UU: 100000 UU/s; 1e6 UU/s² up, 5e5 UU/s² down.
  constexpr Times kTimes{750'000, 100'000, 200'000};
  for (const Row& row :
       {Row{"60C5h", {0x60C5, 0}, 999'999, kTimes}, Row{"60C6h", {0x60C6, 0}, 499'999, kTimes},
        Row{"ramps longer than the move", {}, 0, {299'999, 100'000, 200'000}},
        Row{"no time to accelerate", {}, 0, {750'000, 0, 200'000}},
        Row{"no time to decelerate", {}, 0, {750'000, 100'000, 0}}}) {
    SCOPED_TRACE(row.what);
    Group fresh(1);
    if (row.limit.index != 0) fresh.write(0, row.limit, row.value);
    fresh.start({60'000}, row.times);
    EXPECT_EQ(fresh.bank().ignored_set_points(0), 1U);
    fresh.start({0}, {750'000, 0, 0});
    EXPECT_EQ(fresh.bank().ignored_set_points(0), 2U) << "without any way";
    for (int tick = 0; tick < 50; ++tick) {
      fresh.bank().step();
      ASSERT_EQ(fresh.demand(0), 0);
      ASSERT_FALSE(fresh.shows(0, Statusword::kSetPointAcknowledge));
    }
  }
}

TEST_F(TwoAxes, TheSpeedLimitInForceApplies) {
  Group fresh(1);
  fresh.write(0, {0x6040, 0}, 0x06);
  fresh.write(0, {0x607F, 0}, 99'999);
  fresh.write(0, {0x6040, 0}, 0x0F);
  fresh.bank().step();
  fresh.start({60'000}, {750'000, 100'000, 200'000});  // would need 100000 UU/s
  EXPECT_EQ(fresh.bank().ignored_set_points(0), 1U);
}

TEST_F(TwoAxes, AMovingAxisDoesNotStartASynchronousMove) {
  group.start({60'000, 60'000}, {700'000, 100'000, 100'000});
  group.bank().step();
  group.write(0, {0x6040, 0}, 0x0F);
  group.write(0, {0x607A, 0}, 70'000);
  group.write(0, {0x6040, 0}, 0x3F);
  EXPECT_EQ(group.bank().ignored_set_points(0), 1U);
}

TEST_F(TwoAxes, ABufferedSynchronousMoveStartsFromRestWithItsOwnTimes) {
  group.start({60'000, 20'000}, {700'000, 100'000, 100'000});
  group.bank().step();
  group.start({0, 0}, {500'000, 100'000, 100'000});
  for (int tick = 1; tick < 700; ++tick) group.bank().step();
  ASSERT_EQ(group.demand(0), 60'000);
  for (int tick = 0; tick < 501; ++tick) group.bank().step();
  EXPECT_EQ(group.demand(0), 0);
  EXPECT_EQ(group.demand(1), 0);
}

TEST_F(TwoAxes, TheJerkTimeRoundsBothRampsAndLeavesThePeak) {
  group.write(0, kJerkTime, 50'000);
  group.write(1, kJerkTime, 50'000);
  // 60000 UU in 700 ms with ramps of 100 ms: 60000 / (0.7 - 0.1) s = 100000 UU/s. The acceleration
  // grows for 50 ms to 100000 / (0.1 - 0.05) = 2e6 UU/s², by 4e7 UU/s³, and shrinks for 50 ms.
  group.start({60'000, 20'000}, {700'000, 100'000, 100'000});
  for (int tick = 0; tick < 20; ++tick) group.bank().step();
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 8'000);  // 4e7·0.02²/2
  for (int tick = 20; tick < 50; ++tick) group.bank().step();
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 50'000);
  for (int tick = 50; tick < 300; ++tick) group.bank().step();
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 100'000);
  EXPECT_EQ(group.bank().status(1).velocity_demand_value, 33'333);
  EXPECT_EQ(group.demand(0), 25'000);  // 100000·(0.3 - 0.1/2)
  for (int tick = 300; tick < 699; ++tick) group.bank().step();
  EXPECT_NE(group.bank().status(0).velocity_demand_value, 0);
  group.bank().step();
  EXPECT_EQ(group.demand(0), 60'000);
  EXPECT_EQ(group.demand(1), 20'000);
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 0);
}

TEST_F(TwoAxes, HaltAndResumeWithAJerkTimeStayOnTheStraightLine) {
  group.write(0, kJerkTime, 60'000);
  group.write(1, kJerkTime, 60'000);
  const std::vector<std::int32_t> starts{0, 0};
  const std::vector<std::int32_t> targets{90'000, -30'000};
  group.start(targets, {900'000, 200'000, 300'000});
  for (int tick = 0; tick < 120; ++tick) group.bank().step();  // the first ramp is not over
  group.command(0x010F);
  for (int tick = 0; tick < 600; ++tick) {
    group.bank().step();
    ASSERT_LE(deviation(group, starts, targets), 1.0) << tick;
  }
  ASSERT_EQ(group.bank().status(0).velocity_demand_value, 0);
  ASSERT_NE(group.demand(0), targets[0]);
  group.command(0x000F);
  for (int tick = 0; tick < 1'500; ++tick) {
    group.bank().step();
    ASSERT_LE(deviation(group, starts, targets), 1.0) << tick;
  }
  EXPECT_EQ(group.demand(0), targets[0]);
  EXPECT_EQ(group.demand(1), targets[1]);
}

TEST_F(TwoAxes, AJerkTimeThatARampHasNoRoomForIsNotAccepted) {
  for (const std::int64_t jerk_time : {50'000, 50'001}) {
    Group fresh(1);
    fresh.write(0, kJerkTime, jerk_time);
    fresh.start({60'000}, {750'000, 100'000, 200'000});
    EXPECT_EQ(fresh.bank().ignored_set_points(0), jerk_time > 50'000 ? 1U : 0U) << jerk_time;
  }
}

TEST_F(TwoAxes, AJerkTimeNeedsMoreAcceleration) {
  // 100000 UU/s in 100 ms: 1e6 UU/s² at once, 100000 / (0.1 - 0.02) = 1.25e6 UU/s² with 20 ms.
  for (const std::int64_t limit : {1'249'999, 1'250'001}) {
    Group fresh(1);
    fresh.write(0, {0x60C5, 0}, limit);
    fresh.write(0, kJerkTime, 20'000);
    fresh.start({60'000}, {750'000, 100'000, 200'000});
    EXPECT_EQ(fresh.bank().ignored_set_points(0), limit < 1'250'000 ? 1U : 0U) << limit;
  }
}

TEST_F(TwoAxes, ADurationOf0GivesAnOrdinaryMove) {
  group.start({60'000, 20'000}, {0, 100'000, 100'000});
  group.write(0, {0x6081, 0}, 1);
  for (int tick = 0; tick < 100; ++tick) group.bank().step();
  // 6083h = 409600 UU/s² for 100 ms.
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 40'960);
}

}  // namespace
}  // namespace vdrive
