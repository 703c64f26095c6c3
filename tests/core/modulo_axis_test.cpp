// SPDX-License-Identifier: Apache-2.0
// Modulo axes: the position range 607Bh, the directions of 60F2h bits 6 and 7.
#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;

constexpr std::int64_t kTurn = 4'096;  // range of the table, one revolution
constexpr std::int64_t kAsLinear = 2;  // 60F2h: bits 0 and 1 are 2, the manual's default
constexpr std::int64_t kNegative = 2 + 64;
constexpr std::int64_t kPositive = 2 + 128;
constexpr std::int64_t kShortest = 2 + 192;

/// A rotary table that shows positions in [lower, lower + kTurn).
AxisConfiguration table_at(std::int32_t position, std::int64_t lower = 0) {
  AxisConfiguration configuration;
  configuration.initial_position = position;
  configuration.parameters = {
      {AxisUnderTest::address_of("min_position_range_limit"), lower},
      {AxisUnderTest::address_of("max_position_range_limit"), lower + kTurn}};
  return configuration;
}

/// Follows 6062h round the range.
class Way {
 public:
  explicit Way(AxisUnderTest& axis) : axis_(axis), last_(axis.demand()) {}

  /// To be called after each tick.
  void note() {
    std::int64_t change = axis_.demand() - last_;
    if (change > kTurn / 2) change -= kTurn;
    if (change < -kTurn / 2) change += kTurn;
    last_ = axis_.demand();
    units_ += change;
  }

  [[nodiscard]] std::int64_t units() const { return units_; }

 private:
  AxisUnderTest& axis_;
  std::int64_t last_;
  std::int64_t units_ = 0;
};

void expect_in_range(const AxisUnderTest& axis, std::int64_t lower) {
  ASSERT_GE(axis.demand(), lower);
  ASSERT_LT(axis.demand(), lower + kTurn);
  ASSERT_GE(axis.actual(), lower);
  ASSERT_LT(axis.actual(), lower + kTurn);
}

/// Takes the set-point with `word` and follows it to bit 10.
void follow_set_point(AxisUnderTest& axis, std::uint16_t word, Way& way, std::int64_t lower = 0) {
  axis.command(0x000F);
  way.note();
  axis.command(word);
  way.note();
  for (int ticks = 0; ticks < 5'000 && !axis.reached(); ++ticks) {
    axis.step();
    way.note();
    ASSERT_NO_FATAL_FAILURE(expect_in_range(axis, lower));
  }
  ASSERT_TRUE(axis.reached());
}

std::int64_t way_to(AxisUnderTest& axis, std::int64_t target, std::int64_t option) {
  axis.write("positioning_option_code", option);
  axis.write("position_user_target_value", target);
  Way way(axis);
  follow_set_point(axis, 0x001F, way);
  return way.units();
}

// ---- the range ---------------------------------------------------------------------------------

TEST(PositionRange, IsOffByDefaultAndWhereItsLimitsAreNotInOrder) {
  struct Range {
    std::int64_t lower;
    std::int64_t upper;
  };

  for (const Range& range :
       {Range{0, 0}, Range{4'096, 0}, Range{100, 100}, Range{-2147483648LL, 2147483647}}) {
    AxisConfiguration configuration;
    configuration.initial_position = 10'000;
    AxisUnderTest axis(configuration);
    axis.write("min_position_range_limit", range.lower);
    axis.write("max_position_range_limit", range.upper);
    axis.step();
    EXPECT_EQ(axis.actual(), 10'000) << range.lower << " to " << range.upper;
    EXPECT_EQ(axis.try_write("positioning_option_code", kShortest), AbortCode{0x06090030});
  }
}

TEST(PositionRange, ShowsThePositionInItAndTheUpperLimitAsTheLowerOne) {
  struct Shown {
    std::int32_t position;
    std::int64_t lower;
    std::int32_t shown;
  };

  for (const Shown& row : {Shown{0, 0, 0}, Shown{4'095, 0, 4'095}, Shown{4'096, 0, 0},
                           Shown{-1, 0, 4'095}, Shown{10'000, 0, 1'808}, Shown{-10'000, 0, 2'288},
                           Shown{2'048, -2'048, -2'048}, Shown{-2'048, -2'048, -2'048},
                           Shown{-2'049, -2'048, 2'047}, Shown{50, 1'000'000, 1'003'570}}) {
    SCOPED_TRACE(row.position);
    AxisUnderTest axis(table_at(row.position, row.lower));
    EXPECT_EQ(axis.actual(), row.shown) << "at power-up";
    axis.step();
    EXPECT_EQ(axis.actual(), row.shown);
    EXPECT_EQ(axis.demand(), row.shown);
    EXPECT_EQ(axis.read("load_position_actual_value"), row.shown);
    axis.enable();
    axis.step(10);
    EXPECT_EQ(axis.actual(), row.shown);
    EXPECT_EQ(axis.statusword(), 0x0637);
  }
}

TEST(PositionRange, IsInForceAtOnceAndMovesNothing) {
  AxisConfiguration configuration;
  configuration.initial_position = 5'000;
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.write("max_position_range_limit", kTurn);
  axis.step();
  EXPECT_EQ(axis.actual(), 904);
  EXPECT_EQ(axis.demand_velocity(), 0);
  EXPECT_EQ(axis.statusword(), 0x0637);
  axis.write("max_position_range_limit", 0);
  axis.step();
  EXPECT_EQ(axis.actual(), 5'000);
}

TEST(PositionRange, HasNoStepInTheFollowingErrorOrTheSpeed) {
  AxisUnderTest axis(table_at(0));
  axis.write("op_mode_cmd", 3);
  axis.command(0x000F);
  axis.write("target_velocity", 100'000);
  axis.step(500);
  for (int tick = 0; tick < 2'000; ++tick) {  // about 48 turns
    axis.step();
    ASSERT_NO_FATAL_FAILURE(expect_in_range(axis, 0));
    ASSERT_EQ(axis.demand(), axis.actual());
    ASSERT_EQ(axis.status().load_position_error_value, 0);
    ASSERT_NEAR(axis.velocity(), 100'000, 500);
  }
  axis.write("target_velocity", 0);
  axis.step(1'000);
  axis.write("op_mode_cmd", 1);
  axis.step(10);
  ASSERT_EQ(axis.read("op_mode_actual"), 1);
  way_to(axis, 1'234, kAsLinear);
  axis.step(500);
  EXPECT_EQ(axis.demand(), 1'234);
  EXPECT_NEAR(axis.actual(), 1'234, 2);
}

TEST(PositionRange, WithOneEncoderHoldsForTheMotorToo) {
  AxisConfiguration configuration = table_at(4'000);
  configuration.model.feedback = Feedback::single_encoder;
  AxisUnderTest axis(configuration);
  axis.enable();
  EXPECT_EQ(way_to(axis, 200, kPositive), 296);
  EXPECT_NEAR(axis.actual(), 200, 100) << "in the window 6067h";
  EXPECT_EQ(axis.status().motor_position_actual_value, axis.actual());
  EXPECT_EQ(axis.status().motor_position_error_value, axis.status().load_position_error_value);
}

TEST(PositionRange, WithTwoEncodersTheMotorCountsOn) {
  AxisUnderTest axis(table_at(4'000));
  axis.enable();
  EXPECT_EQ(way_to(axis, 200, kPositive), 296);
  axis.step(500);
  const AxisStatus& status = axis.status();
  EXPECT_NEAR(axis.actual(), 200, 2);
  EXPECT_NEAR(status.motor_position_actual_value, 4'296, 2) << "a gear of 1";
  EXPECT_EQ(status.motor_position_error_value,
            status.position_demand_value - status.motor_position_actual_value);
}

TEST(PositionRange, TakesTheHomeOffsetAsAPlaceInIt) {
  AxisUnderTest axis(table_at(1'000));
  axis.write("home_offset", 5'000);
  axis.write("op_mode_cmd", 6);
  axis.command(0x000F);
  axis.command(0x001F);
  axis.step(100);
  EXPECT_EQ(axis.statusword() & 0x3400, 0x1400) << "homing attained";
  EXPECT_EQ(axis.actual(), 904);
  EXPECT_EQ(axis.demand(), 904);
}

TEST(PositionRange, OfOneAxisIsNothingToItsNeighbours) {
  const auto statuses_of_first = [](bool is_beside_table) {
    std::vector<AxisConfiguration> axes(2);
    if (is_beside_table) axes[1] = table_at(10'000);
    AxisBank bank(axes, std::chrono::microseconds{1'000});
    bank.write(0, {0x6060, 0}, 1);
    bank.write(0, {0x6040, 0}, 0x0F);
    bank.step();
    bank.write(0, {0x607A, 0}, 50'000);
    bank.write(0, {0x6040, 0}, 0x1F);
    std::vector<std::int32_t> seen;
    for (int tick = 0; tick < 2'000; ++tick) {
      bank.step();
      const AxisStatus& status = bank.status(0);
      seen.insert(seen.end(),
                  {status.position_demand_value, status.load_position_actual_value,
                   status.motor_position_actual_value, std::int32_t{status.ds402_statusword}});
    }
    return seen;
  };
  EXPECT_EQ(statuses_of_first(true), statuses_of_first(false));
}

TEST(PositionRange, ComesWithASnapshot) {
  const AxisConfiguration configuration = table_at(3'000);
  AxisBank bank({&configuration, 1}, std::chrono::microseconds{1'000});
  AxisBank other({&configuration, 1}, std::chrono::microseconds{1'000});
  bank.write(0, {0x607B, 2}, 1'000);
  bank.step();
  ASSERT_EQ(bank.status(0).load_position_actual_value, 0) << "3000 modulo 1000";
  other.restore(bank.snapshot());
  bank.step();
  other.step();
  EXPECT_EQ(other.status(0).load_position_actual_value, 0);
  EXPECT_EQ(other.status_hash(), bank.status_hash());
}

// ---- 60F2h -------------------------------------------------------------------------------------

TEST(RotaryDirection, IsRefusedWithoutARangeAndOnlyBits6And7AreNewWithOne) {
  AxisUnderTest linear;
  AxisUnderTest table(table_at(0));
  for (std::int64_t value = 0; value <= 65'535; ++value) {
    const bool is_relative_option = value <= 2;
    const bool has_direction = (value & ~std::int64_t{0xC0}) <= 2;
    ASSERT_EQ(linear.try_write("positioning_option_code", value),
              is_relative_option ? AbortCode::none : AbortCode{0x06090030})
        << value;
    ASSERT_EQ(table.try_write("positioning_option_code", value),
              has_direction ? AbortCode::none : AbortCode{0x06090030})
        << value;
  }
  EXPECT_EQ(table.try_write("positioning_option_code", 65'536), AbortCode{0x06090031});
  EXPECT_EQ(table.try_write("positioning_option_code", -1), AbortCode{0x06090032});
}

TEST(RotaryDirection, IsStoredWithARange) {
  AxisBank bank(std::vector<AxisConfiguration>(1), std::chrono::microseconds{1'000});
  EXPECT_EQ(bank.set_stored(0, {0x60F2, 0}, kShortest), AbortCode::none);
  bank.power_cycle(0);
  EXPECT_EQ(bank.read(0, {0x60F2, 0}).value, 2) << "no modulo axis";
  EXPECT_EQ(bank.set_stored(0, {0x607B, 2}, kTurn), AbortCode::none);
  bank.power_cycle(0);
  EXPECT_EQ(bank.read(0, {0x60F2, 0}).value, kShortest);
}

struct RotaryCase {
  const char* name;
  std::int64_t option;
  std::int32_t start;
  std::int64_t target;
  std::int64_t way;
};

class RotaryWay : public testing::TestWithParam<RotaryCase> {};

TEST_P(RotaryWay, IsThatOf60F2h) {
  const RotaryCase& row = GetParam();
  AxisUnderTest axis(table_at(row.start));
  axis.enable();
  EXPECT_EQ(way_to(axis, row.target, row.option), row.way);
  axis.step(500);
  const std::int64_t end = ((row.start + row.way) % kTurn + kTurn) % kTurn;
  EXPECT_EQ(axis.demand(), end);
  EXPECT_NEAR(axis.actual(), static_cast<double>(end), 2);
  EXPECT_EQ(axis.read("position_user_target_value"), row.target) << "the value is not altered";
}

const std::array<RotaryCase, 17> kRotaryCases{{
    {"linear_forward", kAsLinear, 1'000, 3'000, 2'000},
    {"linear_backward", kAsLinear, 3'000, 1'000, -2'000},
    {"linear_more_than_a_turn", kAsLinear, 1'000, 9'000, 8'000},
    {"linear_below_the_range", kAsLinear, 1'000, -500, -1'500},
    {"negative_to_a_higher_value", kNegative, 1'000, 3'000, -2'096},
    {"negative_to_a_lower_value", kNegative, 3'000, 1'000, -2'000},
    {"negative_to_itself", kNegative, 1'000, 1'000, 0},
    {"negative_to_a_target_outside", kNegative, 1'000, 5'000, -96},
    {"positive_to_a_higher_value", kPositive, 1'000, 3'000, 2'000},
    {"positive_to_a_lower_value", kPositive, 3'000, 1'000, 2'096},
    {"positive_to_itself", kPositive, 1'000, 1'000, 0},
    {"positive_to_a_target_outside", kPositive, 1'000, 5'000, 4'000},
    {"shortest_backward_over_the_end", kShortest, 1'000, 3'500, -1'596},
    {"shortest_forward_over_the_end", kShortest, 3'500, 1'000, 1'596},
    {"shortest_of_two_equal_ways_up", kShortest, 1'000, 3'048, 2'048},
    {"shortest_of_two_equal_ways_down", kShortest, 3'048, 1'000, 2'048},
    {"shortest_to_a_target_outside", kShortest, 1'000, -1'000, -2'000},
}};

INSTANTIATE_TEST_SUITE_P(Cases, RotaryWay, testing::ValuesIn(kRotaryCases), [](const auto& row) {
  return std::string(row.param.name);
});

TEST(RotaryDirection, CountsInARangeThatDoesNotBeginAt0) {
  AxisUnderTest axis(table_at(-2'000, -2'048));
  axis.enable();
  axis.write("positioning_option_code", kShortest);
  axis.write("position_user_target_value", 2'000);
  Way way(axis);
  ASSERT_NO_FATAL_FAILURE(follow_set_point(axis, 0x001F, way, -2'048));
  EXPECT_EQ(way.units(), -96);
  EXPECT_EQ(axis.demand(), 2'000);
}

TEST(RotaryDirection, IsNothingToARelativeTargetWhoseSignIsItsDirection) {
  for (const std::int64_t distance : {-5'000, 300}) {
    AxisUnderTest axis(table_at(1'000));
    axis.enable();
    axis.write("positioning_option_code", distance < 0 ? kPositive : kNegative);
    axis.write("position_user_target_value", distance);
    Way way(axis);
    ASSERT_NO_FATAL_FAILURE(follow_set_point(axis, 0x005F, way));
    EXPECT_EQ(way.units(), distance);
  }
}

/// With weak loops the axis lags while it accelerates: target, demand and actual position differ.
TEST(RotaryDirection, LeavesTheBaseOfARelativeTargetToBits0And1) {
  for (const std::int64_t option : {0, 1, 2}) {
    SCOPED_TRACE(option);
    AxisConfiguration configuration = table_at(0);
    configuration.model.position_loop_bandwidth = 2.0;
    configuration.model.velocity_loop_bandwidth = 10.0;
    AxisUnderTest axis(configuration);
    axis.write("positioning_option_code", option + 64);
    axis.enable();
    axis.write("position_user_target_value", 3'000);
    axis.command(0x007F);
    axis.step(60);
    axis.command(0x000F);
    const std::array<std::int64_t, 3> bases{3'000, axis.demand(), axis.actual()};
    ASSERT_NE(bases[1], bases[2]);
    axis.write("position_user_target_value", 500);
    axis.command(0x007F);
    ASSERT_NE(axis.step_until_reached(20'000), 0U);
    EXPECT_EQ(axis.demand(), bases.at(static_cast<std::size_t>(option)) + 500);
  }
}

TEST(RotaryDirection, OfABufferedTargetIsThatOfItsEdge) {
  AxisUnderTest axis(table_at(0));
  axis.enable();
  Way way(axis);
  axis.write("positioning_option_code", kPositive);
  axis.write("position_user_target_value", 1'000);
  axis.command(0x001F);
  way.note();
  axis.command(0x000F);
  way.note();
  axis.write("positioning_option_code", kNegative);
  axis.write("position_user_target_value", 2'000);
  axis.command(0x001F);
  way.note();
  axis.write("positioning_option_code", kShortest);
  for (int ticks = 0; ticks < 5'000 && !axis.reached(); ++ticks) {
    axis.step();
    way.note();
  }
  EXPECT_EQ(axis.demand(), 2'000);
  EXPECT_EQ(way.units(), 1'000 - 3'096) << "the shorter way from 1000 were 1000 forward";
}

TEST(RotaryDirection, IsWithoutEffectOnceTheRangeIsGone) {
  AxisUnderTest axis(table_at(3'000));
  axis.write("positioning_option_code", kPositive);
  axis.write("max_position_range_limit", 0);
  axis.enable();
  axis.write("position_user_target_value", 1'000);
  axis.command(0x001F);
  ASSERT_NE(axis.step_until_reached(5'000), 0U);
  EXPECT_EQ(axis.demand(), 1'000) << "backward";
  EXPECT_EQ(axis.read("positioning_option_code"), kPositive);
}

TEST(RotaryDirection, IsWithoutEffectInSoftwareLimitsWhichNoWayCrosses) {
  AxisUnderTest axis(table_at(3'400));
  axis.write("user_position_lower_limit", 500);
  axis.write("user_position_upper_limit", 3'500);
  axis.write("app_position_limit_switch", 1);
  axis.enable();
  EXPECT_EQ(way_to(axis, 600, kShortest), -2'800) << "not 1296 through the end of the range";
  EXPECT_FALSE(axis.limit_active());
  EXPECT_EQ(way_to(axis, 4'000, kShortest), 2'900) << "to the limit";
  EXPECT_TRUE(axis.limit_active());
}

/// Past 1500 on a move from 0 to 4000 with 409600 UU/s²: the axis could come to rest at about 3150
/// at the earliest.
class RotaryRetarget : public testing::Test {
 protected:
  RotaryRetarget() {
    axis_.write("profile_velocity", 40'960);
    axis_.enable();
    axis_.write("position_user_target_value", 4'000);
    axis_.command(0x001F);
    way_.note();
    while (axis_.demand() < 1'500) {
      axis_.step();
      way_.note();
    }
    // v² = 2 x 409600 x 1500, and a tick more; the same distance again is needed to stop.
    EXPECT_NEAR(axis_.demand_velocity(), 35'054, 500);
  }

  /// @return the total distance from the start.
  std::int64_t way_over(std::int64_t target, std::int64_t option) {
    axis_.write("positioning_option_code", option);
    axis_.write("position_user_target_value", target);
    axis_.command(0x000F);
    way_.note();
    axis_.command(0x003F);
    way_.note();
    for (int ticks = 0; ticks < 5'000 && !axis_.reached(); ++ticks) {
      axis_.step();
      way_.note();
      turned_back_ = turned_back_ || axis_.demand_velocity() < 0;
    }
    EXPECT_EQ(axis_.demand(), target);
    return way_.units();
  }

  [[nodiscard]] bool turned_back() const { return turned_back_; }

 private:
  AxisUnderTest axis_{table_at(0)};
  Way way_{axis_};
  bool turned_back_ = false;
};

TEST_F(RotaryRetarget, PositiveReachesATargetShortOfTheStopATurnLater) {
  EXPECT_EQ(way_over(2'500, kPositive), 2'500 + kTurn);
  EXPECT_FALSE(turned_back());
}

TEST_F(RotaryRetarget, PositiveReachesATargetPastTheStopInThisTurn) {
  EXPECT_EQ(way_over(3'600, kPositive), 3'600);
  EXPECT_FALSE(turned_back());
}

TEST_F(RotaryRetarget, NegativeBrakesAndTurnsBack) {
  EXPECT_EQ(way_over(2'500, kNegative), 2'500);
  EXPECT_TRUE(turned_back());
}

TEST_F(RotaryRetarget, ShortestIsJudgedFromThePlaceOfRest) {
  // From about 3150 to 700: 2450 back, 1646 forward.
  EXPECT_EQ(way_over(700, kShortest), 700 + kTurn);
  EXPECT_FALSE(turned_back());
}

// ---- cyclic synchronous position ---------------------------------------------------------------

TEST(ModuloAxis, StreamsRoundTheEndOfItsRange) {
  AxisUnderTest axis(table_at(4'080));
  axis.write("op_mode_cmd", 8);
  axis.command(0x000F);
  for (std::int64_t i = 1; i <= 20; ++i) {
    const std::int64_t place = (4'080 + 3 * i) % kTurn;
    axis.write("position_user_target_value", place);
    axis.step();
    ASSERT_EQ(axis.demand(), place);
    ASSERT_EQ(axis.demand_velocity(), 3'000);
    ASSERT_NE(axis.statusword() & 0x1000, 0) << "follows the command";
  }
  axis.write("position_user_target_value", 4'080 + 63);  // outside the range: the same place as 47
  axis.step();
  EXPECT_EQ(axis.demand(), 47);
  EXPECT_EQ(axis.demand_velocity(), 3'000);
  EXPECT_NE(axis.statusword() & 0x1000, 0);
}

}  // namespace
}  // namespace vdrive
