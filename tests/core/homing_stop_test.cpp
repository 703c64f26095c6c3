// SPDX-License-Identifier: Apache-2.0
// Homing on a mechanical stop, methods -1 to -4, with the blocked load of the test bench as the
// stop. tests/core/homing_end_stop_test.cpp does the same with end stops of the model.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace vdrive {
namespace {

using test::AxisUnderTest;

constexpr double kFarStop = 1.0e12;
// The bench blocks the load at the end of the tick that reaches the stop: at 34133 UU/s up to 34 UU
// beyond it. The reading of 6064h and the rounding to whole numbers in this test add 2.
constexpr double kStopError = 36.5;

/// An axis in front of a wall: 5E01h blocks its load there while its torque points to the wall.
class AxisAtWall {
 public:
  /// @param towards direction of the wall, seen from the axis
  AxisAtWall(int towards, double at) : direction(towards), wall(at) {
    axis.write("op_mode_cmd", 6);
    axis.controlword(0x000F);
    ticks(2);
  }

  void start(int method) {
    axis.write("homing_method", method);
    axis.controlword(0x001F);
    tick();
  }

  void tick() {
    const bool was_attained = attained();
    const std::int32_t before = axis.actual();
    axis.step();
    ++time;
    if (attained() && !was_attained) {
      place += axis.velocity() * axis.seconds_per_tick();  // 6064h has jumped to the new frame
      attained_at = time;
    } else {
      place += axis.actual() - before;
    }
    const bool is_there = direction * (place - wall) >= 0.0;
    const bool blocks = is_there && direction * axis.status().torque_actual_value >= 0;
    if (blocks != blocked_) axis.write("test_blocked_load", blocks ? 1 : 0);
    if (blocks && contact_at == 0) {
      contact_at = time;
      wall = place;  // where the load really stops, so that later contacts are at the same place
    }
    blocked_ = blocks;
  }

  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }

  /// @return bits 13, 12 and 10 of 6041h.
  [[nodiscard]] unsigned phase() const { return axis.statusword() & 0x3400U; }

  bool tick_until_phase(unsigned wanted) {
    for (int i = 0; i < 20'000; ++i) {
      tick();
      if (phase() == wanted) return true;
    }
    return false;
  }

  void home(int method) {
    start(method);
    ASSERT_TRUE(tick_until_phase(kHomed)) << "status " << std::hex << axis.statusword();
    ticks(300);
    ASSERT_EQ(phase(), kHomed);
    EXPECT_EQ(axis.state(), PowerState::operation_enabled) << "no following error";
  }

  static constexpr unsigned kRuns = 0x0000;
  static constexpr unsigned kNotStarted = 0x0400;
  static constexpr unsigned kHomed = 0x1400;
  static constexpr unsigned kFailed = 0x2400;

  AxisUnderTest axis;
  int direction;
  double wall;  ///< [UU] in the frame of power-up; after the first contact, where the load stopped
  double place = 0.0;  ///< of the load in the same frame [UU]
  int time = 0;        ///< [ticks of 1 ms]
  int contact_at = 0;  ///< 0 = not yet
  int attained_at = 0;

 private:
  [[nodiscard]] bool attained() const { return (axis.statusword() & 0x1000U) != 0; }

  bool blocked_ = false;
};

struct HardStopRow {
  int method;
  int direction;
  double home;
  double error;
};

class HomingStop : public testing::TestWithParam<HardStopRow> {};

// The walls are at -5000 and 5000, the index pulses at multiples of 4096.
TEST_P(HomingStop, IsHomeOrTheNextIndexPulseIs) {
  const HardStopRow& row = GetParam();
  for (const std::int32_t offset : {0, 1'000, -12'345}) {
    SCOPED_TRACE(offset);
    AxisAtWall bench(row.direction, row.direction * 5'000.0);
    bench.axis.write("home_offset", offset);
    ASSERT_NO_FATAL_FAILURE(bench.home(row.method));
    EXPECT_NEAR(bench.place, row.home, row.error);
    EXPECT_EQ(bench.axis.demand(), offset);
    EXPECT_NEAR(bench.axis.actual(), offset, 3);
  }
}

TEST_P(HomingStop, IsFoundByAnAxisThatStandsAtIt) {
  const HardStopRow& row = GetParam();
  AxisAtWall bench(row.direction, 0.0);
  ASSERT_NO_FATAL_FAILURE(bench.home(row.method));
  const bool index = row.method > -3;
  EXPECT_NEAR(bench.place, index ? -row.direction * 4'096.0 : 0.0, 2.0);
}

TEST_P(HomingStop, IsApproachedAtSearchSpeedAndLeftAtCreepSpeed) {
  const HardStopRow& row = GetParam();
  AxisAtWall bench(row.direction, row.direction * 5'000.0);
  bench.start(row.method);
  std::int32_t towards = 0;
  std::int32_t away = 0;
  for (int i = 0; i < 20'000 && bench.phase() != AxisAtWall::kHomed; ++i) {
    bench.tick();
    const std::int32_t speed = row.direction * bench.axis.demand_velocity();
    towards = std::max(towards, speed);
    away = std::max(away, -speed);
    if (bench.contact_at == 0) {
      EXPECT_GE(speed, 0);
    }
  }
  EXPECT_EQ(towards, 34'133) << "6099h:01";
  EXPECT_EQ(away, 3'413) << "6099h:02";
}

TEST_P(HomingStop, EndsARunBehindALimitSwitchWithAnError) {
  const HardStopRow& row = GetParam();
  AxisAtWall bench(row.direction, row.direction * 5'000.0);
  bench.start(row.method);
  bench.ticks(100);
  ASSERT_EQ(bench.contact_at, 0);
  bench.axis.write(row.direction > 0 ? "test_positive_limit_input" : "test_negative_limit_input",
                   1);
  ASSERT_TRUE(bench.tick_until_phase(AxisAtWall::kFailed));
  EXPECT_EQ(bench.axis.state(), PowerState::operation_enabled) << "no fault";
}

INSTANTIATE_TEST_SUITE_P(Homing, HomingStop,
                         testing::Values(HardStopRow{-1, -1, -4'096.0, 2.0},
                                         HardStopRow{-2, +1, 4'096.0, 2.0},
                                         HardStopRow{-3, -1, -5'000.0, kStopError},
                                         HardStopRow{-4, +1, 5'000.0, kStopError}),
                         [](const auto& row) {
                           return "Minus" + std::to_string(-row.param.method);
                         });

// A load blocked at 34133 UU/s stands still in the next tick; the demand is 64 UU ahead 2 ticks
// later, and the velocity loop, 100 Hz, produces any torque within a few ms.
TEST(HomingStopTime, IsThatForWhichTheAxisStands) {
  for (const int milliseconds : {0, 20, 100, 2'000}) {
    SCOPED_TRACE(milliseconds);
    AxisAtWall bench(-1, -5'000.0);
    bench.axis.write("homing_stop_time", milliseconds);
    ASSERT_NO_FATAL_FAILURE(bench.home(-3));
    const int lasted = bench.attained_at - bench.contact_at;
    EXPECT_GE(lasted, milliseconds);
    EXPECT_LE(lasted, milliseconds + 30);
  }
}

TEST(HomingStopTime, StartsAgainWhenTheStopGivesWay) {
  AxisAtWall bench(-1, -5'000.0);
  bench.start(-3);
  for (int i = 0; i < 1'000 && bench.contact_at == 0; ++i) bench.tick();
  bench.ticks(60);  // of 100
  EXPECT_EQ(bench.phase(), AxisAtWall::kRuns);
  bench.wall = -15'000.0;
  bench.contact_at = 0;
  ASSERT_TRUE(bench.tick_until_phase(AxisAtWall::kHomed));
  bench.ticks(300);
  EXPECT_NEAR(bench.place, -15'000.0, kStopError);
  EXPECT_GE(bench.attained_at - bench.contact_at, 100);
}

TEST(HomingStopTorque, AboveWhatALimitLetsThroughCountsAsThatLimit) {
  for (const int method : {-3, -4}) {
    for (const bool relative : {false, true}) {
      SCOPED_TRACE(std::to_string(method) + (relative ? ", 60E0h and 60E1h" : ", 6072h"));
      AxisAtWall bench(method == -3 ? -1 : 1, method == -3 ? -5'000.0 : 5'000.0);
      bench.axis.write("homing_acceleration", 100'000);
      bench.axis.write("homing_stop_torque", 65'535);
      if (relative) {
        bench.axis.write("positive_torque_limit_relative", 250);
        bench.axis.write("negative_torque_limit_relative", 250);
      } else {
        bench.axis.write("max_torque", 250);
      }
      ASSERT_NO_FATAL_FAILURE(bench.home(method));
      EXPECT_NEAR(bench.place, method == -3 ? -5'000.0 : 5'000.0, kStopError);
    }
  }
}

// 500 per mille of 3 N.m pull the axis away from the wall: more than 5E18h:01 from the start and
// all the way. Only at the wall does the axis stand still.
TEST(HomingStopTorque, OfALoadIsNoStopWhileTheAxisMoves) {
  AxisAtWall bench(-1, -5'000.0);
  bench.axis.write("test_load_torque", 1'500);
  bench.ticks(1'000);
  ASSERT_LT(bench.axis.status().torque_actual_value, -400);
  bench.axis.write("homing_stop_time", 0);
  const double from = bench.place;
  ASSERT_NO_FATAL_FAILURE(bench.home(-3));
  EXPECT_NEAR(from, 0.0, 5.0);
  EXPECT_NEAR(bench.place, -5'000.0, kStopError);
}

// Without a wall the axis runs on and never stands still.
TEST(HomingStopTorque, IsNotReachedByAnAxisThatAccelerates) {
  AxisAtWall bench(1, kFarStop);
  bench.axis.write("homing_acceleration", 4'000'000);  // 1227 per mille of the rated torque
  bench.axis.write("homing_stop_time", 0);
  bench.start(-4);
  bench.ticks(2'000);
  EXPECT_EQ(bench.phase(), AxisAtWall::kRuns);
  EXPECT_EQ(bench.axis.demand_velocity(), 34'133);
}

TEST(HomingStopHalt, LetsARunThatPressesContinue) {
  AxisAtWall bench(-1, -5'000.0);
  bench.axis.write("homing_stop_time", 5'000);
  bench.start(-1);
  for (int i = 0; i < 1'000 && bench.contact_at == 0; ++i) bench.tick();
  bench.ticks(1'000);
  bench.axis.controlword(0x011F);
  ASSERT_TRUE(bench.tick_until_phase(AxisAtWall::kNotStarted));
  bench.axis.controlword(0x001F);
  bench.tick();
  EXPECT_EQ(bench.phase(), AxisAtWall::kRuns);
}

TEST(HomingStopHalt, EndsARunThatPresses) {
  AxisAtWall bench(-1, -5'000.0);
  bench.axis.write("homing_stop_time", 5'000);
  bench.start(-1);
  for (int i = 0; i < 1'000 && bench.contact_at == 0; ++i) bench.tick();
  bench.ticks(1'000);
  EXPECT_EQ(bench.phase(), AxisAtWall::kRuns);
  EXPECT_EQ(bench.axis.demand_velocity(), 0) << "the demand waits, so that 6065h is kept";
  EXPECT_LT(std::abs(bench.axis.demand() - bench.axis.actual()), 3'000);
  bench.axis.controlword(0x011F);
  ASSERT_TRUE(bench.tick_until_phase(AxisAtWall::kNotStarted));
  bench.axis.controlword(0x000F);
  bench.ticks(6'000);
  EXPECT_EQ(bench.phase(), AxisAtWall::kNotStarted) << "nothing resumes";
}

TEST(HomingStopObjects, HaveTheirDefaults) {
  const AxisUnderTest axis;
  EXPECT_EQ(axis.read("homing_stop_torque"), 200) << "20 % of the rated torque";
  EXPECT_EQ(axis.read("homing_stop_time"), 100) << "ms";
}

}  // namespace
}  // namespace vdrive
