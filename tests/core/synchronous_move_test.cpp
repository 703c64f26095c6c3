// SPDX-License-Identifier: Apache-2.0
//
// Synchronous move 5E10h: axes that start in the same tick with the same times keep the proportions
// of their displacements and arrive in the same tick.
#include "support/effort.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace vdrive {
namespace {

using std::chrono::microseconds;

constexpr ObjectAddress kDuration{0x5E10, 1};
constexpr ObjectAddress kAccelerationTime{0x5E10, 2};
constexpr ObjectAddress kDecelerationTime{0x5E10, 3};
constexpr ObjectAddress kJerkTime{0x5E10, 4};
constexpr ObjectAddress kReferenceWay{0x5E10, 5};
constexpr std::int64_t kUnlimited = 4294967040;

struct Times {
  std::uint32_t duration_us;
  std::uint32_t acceleration_us;
  std::uint32_t deceleration_us;
};

/// Enabled axes in profile position mode, with torque and speed limits too high to matter.
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

/// Largest distance of the demands from the straight line between starts and targets; the axis with
/// the longest distance to travel gives the point on the line.
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

/// Shortest triangle over `way` within 60C5h: way = a·(T/2)², with some slack for the rounding to
/// ticks.
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
      // Distances of every magnitude from 0 to 1e9 units, positions within ±1e9.
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
      group.start(targets, times, 0x3F);  // the axes may still lag from the previous move

      // All axes are at rest on their targets in the tick that completes the duration.
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

/// A line through 0 whose direction consists of whole units, so that points on it are exact.
struct Direction {
  std::int32_t first;
  std::int32_t second;

  [[nodiscard]] std::vector<std::int32_t> at(std::int32_t multiple) const {
    return {first * multiple, second * multiple};
  }
};

/// Drives two axes on a line and, while they move, turns to another target on it.
class TurningLine {
 public:
  explicit TurningLine(std::uint64_t seed) : random_(seed) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      group.write(axis, {0x6067, 0}, 4294967295);  // bit 10 does not wait for the window time
    }
  }

  /// Similar times, so that a line that must come back has done so within seconds.
  Times any_times() {
    const std::uint32_t up = uniform(100'000, 120'000);
    const std::uint32_t down = uniform(100'000, 120'000);
    return {up + down + uniform(0, 40'000), up, down};
  }

  /// Starts the line to `targets` with a random jerk time.
  void start(const std::vector<std::int32_t>& targets, const Times& times,
             const std::vector<std::int32_t>& reference_ways) {
    const std::uint32_t most = std::min(times.acceleration_us, times.deceleration_us) / 2;
    const std::uint32_t jerk_time = uniform(0, 3) == 0 ? 0U : uniform(most / 2, most);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      group.write(axis, kJerkTime, jerk_time);
      group.write(axis, kReferenceWay, std::abs(reference_ways[axis]));
    }
    group.start(targets, times, 0x3F);
  }

  std::uint32_t uniform(std::uint32_t low, std::uint32_t high) {
    return std::uniform_int_distribution<std::uint32_t>(low, high)(random_);
  }

  Group group{2};

 private:
  std::mt19937_64 random_;
};

TEST(SynchronousMove, WithAReferenceWayStartsInMotionAndKeepsItsStraightLineWithinAUnit) {
  // Measured in multiples of `direction`, the speed is at most 20000 /s, or 50000 /s if an
  // acceleration must end first. Braking with at least 1e5 /s² then takes half a second and goes
  // 20000 too far; the way back at 9000 /s takes 2 s.
  constexpr int kLongest = 10'000;        // ticks
  constexpr double kUnit = 1.0 + 1.0e-6;  // includes the last bits of the line
  for (int run = 0; run < kMovesOfABank; ++run) {
    SCOPED_TRACE("run " + std::to_string(run));
    TurningLine line(static_cast<std::uint64_t>(run));
    Group& group = line.group;
    const auto sign = line.uniform(0, 1) == 0 ? 1 : -1;
    const Direction direction{static_cast<std::int32_t>(line.uniform(1, 1'000)),
                              sign * static_cast<std::int32_t>(line.uniform(1, 1'000))};
    const auto multiple = [&line](std::uint32_t low, std::uint32_t high) {
      return static_cast<std::int32_t>(line.uniform(low, high));
    };
    const std::vector<std::int32_t> starts{0, 0};
    const std::vector<std::int32_t> measure = direction.at(1'000);
    const Times first = line.any_times();
    line.start(direction.at(multiple(1'500, 2'000)), first, {0, 0});
    const std::uint32_t turn = line.uniform(1, first.duration_us / 1'000 - 1);
    for (std::uint32_t tick = 0; tick < turn; ++tick) group.bank().step();

    // Targets farther on, short of the first end, within the stopping distance, or back past the
    // start.
    const std::vector<std::int32_t> targets = direction.at(multiple(0, 6'000) - 2'000);
    line.start(targets, line.any_times(), direction.at(multiple(1'500, 2'000)));
    std::vector<int> arrivals(2, 0);
    for (int tick = 1; tick <= kLongest && (arrivals[0] == 0 || arrivals[1] == 0); ++tick) {
      group.bank().step();
      ASSERT_LE(deviation(group, starts, measure), kUnit) << "tick " << tick;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        if (arrivals[axis] == 0 && group.shows(axis, Statusword::kTargetReached)) {
          arrivals[axis] = tick;
        }
      }
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      ASSERT_EQ(group.bank().ignored_set_points(axis), 0U) << "axis " << axis;
      ASSERT_EQ(group.demand(axis), targets[axis]) << "axis " << axis;
    }
    // The last bits of the two plans may fall on different sides of a tick.
    ASSERT_LE(std::abs(arrivals[0] - arrivals[1]), 1);
  }
}

/// Two axes whose bit 10 does not wait for the window time.
class TwoAxes : public testing::Test {
 protected:
  TwoAxes() {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      group.write(axis, {0x6067, 0}, 4294967295);
    }
  }

  void refer(const std::vector<std::int64_t>& ways) {
    for (std::size_t axis = 0; axis < 2; ++axis) group.write(axis, kReferenceWay, ways[axis]);
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

/// A set-point whose times cannot be kept is not acknowledged; it is counted and moves nothing.
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

// 6 UU in 10 s with ramps of 5 s: 1.2 UU/s and 0.24 UU/s². 606Bh shows 0 once less than 0.5 UU/s
// remains, for 2083 ms, and 6062h shows the target once less than half a unit remains, for
// sqrt(2·0.5/0.24) s = 2041 ms.
TEST_F(TwoAxes, AnAxisThatShowsItsArrivalStartsASynchronousMove) {
  group.start({6, 6}, {10'000'000, 5'000'000, 5'000'000});
  for (int tick = 0; tick < 7'950; ++tick) group.bank().step();
  ASSERT_EQ(group.demand(0), 5);
  ASSERT_EQ(group.bank().status(0).velocity_demand_value, 0);
  group.start({60'000, 6}, {700'000, 100'000, 100'000}, 0x3F);
  EXPECT_EQ(group.bank().ignored_set_points(0), 1U) << "6062h is not at the target";
  for (int tick = 0; tick < 20; ++tick) group.bank().step();
  ASSERT_EQ(group.demand(0), 6);
  group.start({60'000, 6}, {700'000, 100'000, 100'000}, 0x3F);
  EXPECT_EQ(group.bank().ignored_set_points(0), 1U);
  for (int tick = 0; tick < 700; ++tick) group.bank().step();
  EXPECT_EQ(group.demand(0), 60'000);
  EXPECT_EQ(group.demand(1), 6);
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 0);
}

// 60000 UU in 700 ms with ramps of 100 ms: 100000 UU/s and 1e6 UU/s². After 300 ms the axis is at
// 100000·(0.3 - 0.1/2) = 25000 at full speed.
TEST_F(TwoAxes, AReferenceWayLetsItGoOnWithTheSpeedAndTheRampsOfThatWay) {
  constexpr Times kTimes{700'000, 100'000, 100'000};
  group.start({60'000, 20'000}, kTimes);
  for (int tick = 0; tick < 300; ++tick) group.bank().step();
  ASSERT_EQ(group.demand(0), 25'000);
  refer({60'000, 20'000});
  group.start({120'000, 40'000}, kTimes, 0x3F);
  // 95000 UU remain: 90000 at full speed in 900 ms, 5000 in the ramp of 100 ms.
  for (int tick = 0; tick < 900; ++tick) {
    group.bank().step();
    ASSERT_EQ(group.bank().status(0).velocity_demand_value, 100'000) << tick;
    ASSERT_EQ(group.bank().status(1).velocity_demand_value, 33'333) << tick;
  }
  for (int tick = 900; tick < 999; ++tick) group.bank().step();
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 1'000);
  group.bank().step();
  EXPECT_EQ(group.demand(0), 120'000);
  EXPECT_EQ(group.demand(1), 40'000);
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 0);
}

TEST_F(TwoAxes, AReferenceWayLetsItStopBeforeItsEnd) {
  constexpr Times kTimes{700'000, 100'000, 100'000};
  group.start({60'000, 20'000}, kTimes);
  for (int tick = 0; tick < 300; ++tick) group.bank().step();
  refer({60'000, 20'000});
  group.start({36'000, 12'000}, kTimes, 0x3F);
  // 11000 UU remain: 6000 at full speed in 60 ms, 5000 in 100 ms.
  for (int tick = 0; tick < 60; ++tick) group.bank().step();
  EXPECT_EQ(group.demand(0), 31'000);
  for (int tick = 60; tick < 159; ++tick) group.bank().step();
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 1'000);
  group.bank().step();
  EXPECT_EQ(group.demand(0), 36'000);
  EXPECT_EQ(group.demand(1), 12'000);
}

TEST_F(TwoAxes, AReferenceWayFromRestGivesTheSameSpeedAndRamps) {
  refer({60'000, 20'000});
  // Half of the reference way: ramps of 100 ms and 5000 UU, and 20000 UU in 200 ms between them.
  group.start({30'000, 10'000}, {700'000, 100'000, 100'000});
  for (int tick = 0; tick < 200; ++tick) group.bank().step();
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 100'000);
  for (int tick = 200; tick < 399; ++tick) group.bank().step();
  EXPECT_EQ(group.bank().status(0).velocity_demand_value, 1'000);
  group.bank().step();
  EXPECT_EQ(group.demand(0), 30'000);
  EXPECT_EQ(group.demand(1), 10'000);
}

TEST_F(TwoAxes, AReferenceWayBeyondTheLimitsIsNotAccepted) {
  // 60000 UU: 100000 UU/s in 100 ms, 1e6 UU/s². The 6 UU of the move alone would need 100 UU/s².
  for (const std::int64_t limit : {999'999, 1'000'001}) {
    Group fresh(1);
    fresh.write(0, {0x60C5, 0}, limit);
    fresh.write(0, kReferenceWay, 60'000);
    fresh.start({6}, {700'000, 100'000, 100'000});
    EXPECT_EQ(fresh.bank().ignored_set_points(0), limit < 1'000'000 ? 1U : 0U) << limit;
  }
}

TEST_F(TwoAxes, HaltAndResumeAfterAStartInMotionStayOnTheStraightLine) {
  for (std::size_t axis = 0; axis < 2; ++axis) group.write(axis, kJerkTime, 60'000);
  const std::vector<std::int32_t> starts{0, 0};
  const std::vector<std::int32_t> targets{180'000, -60'000};
  group.start({90'000, -30'000}, {900'000, 200'000, 300'000});
  for (int tick = 0; tick < 120; ++tick) group.bank().step();  // within the first ramp
  refer({90'000, 30'000});
  group.start(targets, {900'000, 200'000, 300'000}, 0x3F);
  for (int tick = 0; tick < 300; ++tick) group.bank().step();
  group.command(0x010F);
  for (int tick = 0; tick < 600; ++tick) {
    group.bank().step();
    ASSERT_LE(deviation(group, starts, targets), 1.0) << tick;
  }
  ASSERT_EQ(group.bank().status(0).velocity_demand_value, 0);
  ASSERT_NE(group.demand(0), targets[0]);
  group.command(0x000F);
  for (int tick = 0; tick < 2'000; ++tick) {
    group.bank().step();
    ASSERT_LE(deviation(group, starts, targets), 1.0) << tick;
  }
  EXPECT_EQ(group.demand(0), targets[0]);
  EXPECT_EQ(group.demand(1), targets[1]);
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
  // grows for 50 ms to 100000 / (0.1 - 0.05) = 2e6 UU/s², with 4e7 UU/s³, and falls for 50 ms.
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
  for (int tick = 0; tick < 120; ++tick) group.bank().step();  // within the first ramp
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
  // 100000 UU/s in 100 ms: 1e6 UU/s² without a jerk time, 100000 / (0.1 - 0.02) = 1.25e6 UU/s² with
  // 20 ms.
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
