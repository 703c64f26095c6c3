// SPDX-License-Identifier: Apache-2.0
// Velocity mode of inverters (6060h = 2): units, ramps, bits 4 to 6, limits, stops, status bits.
// A revolution has 4096 UU: 1 rpm is 4096/60 UU/s, 300 rpm are 20480 UU/s.
#include "core/support/axis_under_test.hpp"
#include "support/random_cases.hpp"
#include "vdrive/cia402/bit_names.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using test::Random;

constexpr std::uint16_t kRunRamp = 0x007F;  // enable operation with bits 4, 5 and 6
constexpr std::int32_t kSpeedOf300 = 20'480;

/// Ramps that cannot be confused [UU/s per tick of 1 ms]: 6048h 102.4, 6049h 204.8, 604Ah 409.6,
/// 6084h 50, 6085h 100, 60C6h 800.
void set_vl_ramps(AxisUnderTest& axis) {
  axis.write("vl_acceleration_delta_speed", 1'500);
  axis.write("vl_deceleration_delta_speed", 6'000);
  axis.write("vl_deceleration_delta_time", 2);
  axis.write("vl_quick_stop_delta_speed", 6'000);
  axis.write("profile_dec", 50'000);
  axis.write("quick_stop_deceleration", 100'000);
  axis.write("app_dec_limit", 800'000);
}

/// Decrease of 606Bh in ten ticks by an option of 605Ah, 605Dh or 605Eh.
std::int32_t loss_by_option(std::int64_t option) {
  constexpr std::array<std::int32_t, 5> kLosses{0, 2'048, 4'096, 8'000, 8'000};
  return kLosses.at(static_cast<std::size_t>(option));
}

void enable_vl(AxisUnderTest& axis) {
  axis.write("op_mode_cmd", 2);
  axis.command(0x000F);
}

/// Turning at 300 rpm in either direction.
void turn_at_300(AxisUnderTest& axis, int sign = 1) {
  set_vl_ramps(axis);
  enable_vl(axis);
  axis.write("vl_target_velocity", sign * 300);
  axis.command(kRunRamp);
  axis.step(400);
  ASSERT_EQ(axis.demand_velocity(), sign * kSpeedOf300);
  ASSERT_NEAR(axis.velocity(), sign * kSpeedOf300, 100);
}

// ---- units and ramps ---------------------------------------------------------------------------

TEST(VelocityMode, TurnsAtTheRpmOf6042hWithTheRampOf6048h) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    set_vl_ramps(axis);
    enable_vl(axis);
    axis.write("vl_target_velocity", sign * 300);
    axis.command(kRunRamp);
    EXPECT_EQ(axis.demand_velocity(), sign * 102) << "1500 rpm/s for 1 ms";
    axis.step(99);
    EXPECT_EQ(axis.demand_velocity(), sign * 10'240);
    EXPECT_EQ(axis.read("vl_velocity_demand"), sign * 150);
    axis.step(100);
    EXPECT_EQ(axis.demand_velocity(), sign * kSpeedOf300);
    EXPECT_EQ(axis.read("vl_velocity_demand"), sign * 300);
    axis.step(500);
    EXPECT_NEAR(static_cast<double>(axis.read("vl_velocity_actual_value")), sign * 300, 1);
    EXPECT_EQ(axis.demand(), axis.actual()) << "the position loop is open";
  }
}

TEST(VelocityMode, SlowsDownWith6049hAndReversesThroughBothRamps) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(turn_at_300(axis));
  axis.write("vl_target_velocity", -300);
  axis.step(10);
  EXPECT_EQ(axis.demand_velocity(), kSpeedOf300 - 2'048);
  axis.step(90);
  EXPECT_EQ(axis.demand_velocity(), 0) << "20480 / 204.8 ticks";
  axis.step(10);
  EXPECT_EQ(axis.demand_velocity(), -1'024);
}

/// With the same ramps and speeds the motions of both modes are identical to the bit.
TEST(VelocityMode, MovesAsProfileVelocityDoesInItsOwnUnits) {
  AxisUnderTest vl;
  AxisUnderTest pv;
  set_vl_ramps(vl);
  pv.write("profile_acc", 102'400);
  pv.write("profile_dec", 204'800);
  enable_vl(vl);
  vl.controlword(kRunRamp);
  pv.write("op_mode_cmd", 3);
  pv.command(0x000F);
  for (const std::int64_t rpm : {300, 150, -600, 0, 15}) {
    vl.write("vl_target_velocity", rpm);
    pv.write("target_velocity", rpm * 4'096 / 60);  // a whole number for each of them
    for (int tick = 0; tick < 300; ++tick) {
      vl.step();
      pv.step();
      ASSERT_EQ(vl.demand_velocity(), pv.demand_velocity()) << rpm << ", tick " << tick;
      ASSERT_EQ(vl.actual(), pv.actual());
      ASSERT_EQ(vl.status().torque_actual_value, pv.status().torque_actual_value);
    }
  }
}

TEST(VelocityMode, RampsAreQuotientsWithin60C5hAnd60C6hAndLive) {
  AxisUnderTest axis;
  set_vl_ramps(axis);
  enable_vl(axis);
  axis.write("vl_target_velocity", 1'000);
  axis.command(kRunRamp);
  axis.step(99);
  ASSERT_EQ(axis.demand_velocity(), 10'240);
  axis.write("vl_acceleration_delta_time", 2);  // 750 rpm/s: 51.2 UU/s per tick
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 15'360);
  axis.write("app_acc_limit", 10'000);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 16'360);
  axis.write("vl_acceleration_delta_speed", 0);
  axis.step(1'000);
  EXPECT_EQ(axis.demand_velocity(), 16'361) << "0 counts as 1 UU/s²";
}

TEST(VelocityMode, TheDimensionFactorMakesRevolutionsASecondOfEverySpeed) {
  AxisUnderTest axis;
  axis.write("vl_dimension_factor_numerator", 60);
  axis.write("vl_acceleration_delta_speed", 25);  // 1500 rpm/s
  enable_vl(axis);
  axis.write("vl_target_velocity", 5);
  axis.command(kRunRamp);
  axis.step(99);
  EXPECT_EQ(axis.demand_velocity(), 10'240);
  axis.step(600);
  EXPECT_EQ(axis.demand_velocity(), kSpeedOf300);
  EXPECT_EQ(axis.read("vl_velocity_demand"), 5);
  EXPECT_EQ(axis.read("vl_velocity_actual_value"), 5);
  axis.write("vl_velocity_max_amount", 4);
  axis.step(200);
  EXPECT_EQ(axis.demand_velocity(), 16'384) << "4 revolutions a second";
}

TEST(VelocityMode, TheSetPointFactorIsOf6042h6043hAnd6044hAlone) {
  AxisUnderTest axis;
  set_vl_ramps(axis);
  axis.write("vl_set_point_factor_denominator", 10);
  enable_vl(axis);
  axis.write("vl_target_velocity", 3'000);
  axis.command(kRunRamp);
  axis.step(99);
  EXPECT_EQ(axis.demand_velocity(), 10'240) << "the ramp has no set-point factor";
  axis.step(600);
  EXPECT_EQ(axis.demand_velocity(), kSpeedOf300);
  EXPECT_EQ(axis.read("vl_velocity_demand"), 3'000);
  EXPECT_NEAR(static_cast<double>(axis.read("vl_velocity_actual_value")), 3'000, 10);
}

TEST(VelocityMode, ANegativeFactorTurnsTheDirectionAndNotTheLimits) {
  for (const char* const factor :
       {"vl_set_point_factor_numerator", "vl_dimension_factor_denominator"}) {
    SCOPED_TRACE(factor);
    AxisUnderTest axis;
    axis.write(factor, -1);
    enable_vl(axis);
    axis.write("vl_target_velocity", 300);
    axis.command(kRunRamp);
    axis.step(600);
    EXPECT_EQ(axis.demand_velocity(), -kSpeedOf300);
    EXPECT_EQ(axis.read("vl_velocity_demand"), 300);
  }
}

TEST(VelocityMode, CountsRpmOfTheMotorBehindAGear) {
  AxisConfiguration configuration;
  configuration.parameters = {{AxisUnderTest::address_of("gear_ratio_denominator"), 10}};
  AxisUnderTest axis(configuration);
  set_vl_ramps(axis);
  enable_vl(axis);
  axis.write("vl_target_velocity", 300);
  axis.command(kRunRamp);
  axis.step(99);
  EXPECT_EQ(axis.demand_velocity(), 1'024) << "1500 rpm/s of the motor, a tenth of it at the load";
  axis.step(1'500);
  EXPECT_EQ(axis.demand_velocity(), 2'048);
  EXPECT_EQ(axis.read("vl_velocity_demand"), 300);
  EXPECT_NEAR(static_cast<double>(axis.read("vl_velocity_actual_value")), 300, 2);
  EXPECT_NEAR(axis.status().motor_velocity_actual_value, kSpeedOf300, 100);
}

TEST(VelocityMode, AFactorOf0AndATimeOf0AreRefused) {
  AxisUnderTest axis;
  for (const char* const factor :
       {"vl_set_point_factor_numerator", "vl_set_point_factor_denominator",
        "vl_dimension_factor_numerator", "vl_dimension_factor_denominator"}) {
    EXPECT_EQ(axis.try_write(factor, 0), AbortCode{0x06090030}) << factor;
    EXPECT_EQ(axis.read(factor), 1) << factor;
  }
  for (const char* const time :
       {"vl_acceleration_delta_time", "vl_deceleration_delta_time", "vl_quick_stop_delta_time"}) {
    EXPECT_EQ(axis.try_write(time, 0), AbortCode{0x06090032}) << time;
  }
  EXPECT_EQ(axis.try_write("vl_target_velocity", 32'768), AbortCode{0x06090031});
  EXPECT_EQ(axis.try_write("vl_velocity_demand", 0), AbortCode{0x06010002});
  EXPECT_EQ(axis.try_write("vl_velocity_actual_value", 0), AbortCode{0x06010002});
}

TEST(VelocityMode, ObjectsOfFrequencyConvertersDoNotExist) {
  AxisUnderTest axis;
  // 6045h control effort, 6047h limits by sign, 604Dh pole number, 604Eh reference, 604Fh to 6051h
  // ramp times, 6052h to 6059h percentages.
  for (const unsigned index :
       {0x6045U, 0x6047U, 0x604DU, 0x604EU, 0x604FU, 0x6050U, 0x6051U, 0x6052U, 0x6053U, 0x6054U,
        0x6055U, 0x6056U, 0x6057U, 0x6058U, 0x6059U}) {
    const ObjectAddress address{static_cast<std::uint16_t>(index), 0};
    EXPECT_EQ(axis.axis().write(address, 1), AbortCode{0x06020000}) << index;
    EXPECT_EQ(axis.axis().read(address).code, AbortCode{0x06020000}) << index;
  }
}

// ---- bits 4 to 6 -------------------------------------------------------------------------------

struct RampBits {
  const char* name;
  std::uint16_t word;
  std::int32_t loss;  // of 606Bh in ten ticks
};

class VelocityRampBits : public testing::TestWithParam<RampBits> {};

TEST_P(VelocityRampBits, DecideOnTheRamp) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    ASSERT_NO_FATAL_FAILURE(turn_at_300(axis, sign));
    axis.controlword(GetParam().word);
    axis.step(10);
    EXPECT_EQ(axis.demand_velocity(), sign * (kSpeedOf300 - GetParam().loss));
    EXPECT_EQ(axis.state(), PowerState::operation_enabled);
    EXPECT_EQ(axis.status().ignored_set_points, 0U) << "levels, not edges";
    axis.command(kRunRamp);
    axis.step(300);
    EXPECT_EQ(axis.demand_velocity(), sign * kSpeedOf300);
  }
}

// Halt with 605Dh = 1 brakes with 6049h: 2048 in ten ticks; bit 4 = 0 alone uses 604Ah.
const std::array<RampBits, 12> kRampBits{{
    {"all", 0x007F, 0},
    {"without_enable", 0x006F, 4'096},
    {"without_unlock", 0x005F, 0},
    {"without_reference", 0x003F, 2'048},
    {"enable_alone", 0x001F, 0},  // locked
    {"unlock_alone", 0x002F, 4'096},
    {"reference_alone", 0x004F, 4'096},
    {"none", 0x000F, 4'096},
    {"halt_alone", 0x010F, 2'048},
    {"halt_and_unlock", 0x012F, 2'048},
    {"halt_without_enable", 0x016F, 2'048},
    {"halt_without_unlock", 0x015F, 2'048},
}};

INSTANTIATE_TEST_SUITE_P(Words, VelocityRampBits, testing::ValuesIn(kRampBits),
                         [](const auto& row) {
                           return std::string(row.param.name);
                         });

TEST(VelocityMode, ALockedRampHoldsItsOutputWhateverChangesBefore) {
  AxisUnderTest axis;
  set_vl_ramps(axis);
  enable_vl(axis);
  axis.write("vl_target_velocity", 300);
  axis.command(kRunRamp);
  axis.step(99);
  ASSERT_EQ(axis.demand_velocity(), 10'240);
  axis.command(0x005F);
  axis.write("vl_target_velocity", -600);
  axis.write("vl_acceleration_delta_speed", 9'000);
  axis.step(50);
  EXPECT_EQ(axis.demand_velocity(), 10'240);
  axis.command(0x001F);
  axis.step(50);
  EXPECT_EQ(axis.demand_velocity(), 10'240) << "bit 6 is of the input";
  axis.command(kRunRamp);
  EXPECT_EQ(axis.demand_velocity(), 10'035) << "204.8 UU/s less: it goes to -600 rpm";
}

TEST(VelocityMode, EnablingTurnsNothingWithoutBits4To6) {
  AxisUnderTest axis;
  axis.write("vl_target_velocity", 300);
  enable_vl(axis);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 0);
  EXPECT_EQ(axis.statusword(), 0x0637) << "the input of the ramp is 0";
  axis.command(0x0006);
  axis.command(kRunRamp);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), kSpeedOf300) << "6000 rpm/s by default";
}

TEST(VelocityMode, TakesNoTargetOfAnotherModeAndGivesNoneToIt) {
  AxisUnderTest axis;
  axis.write("target_velocity", 50'000);
  enable_vl(axis);
  axis.command(kRunRamp);
  axis.step(50);
  EXPECT_EQ(axis.demand_velocity(), 0);
  axis.write("target_velocity", 0);
  axis.write("op_mode_cmd", 3);
  axis.write("vl_target_velocity", 300);
  axis.step(50);
  EXPECT_EQ(axis.read("op_mode_actual"), 3);
  EXPECT_EQ(axis.demand_velocity(), 0);
}

// ---- limits ------------------------------------------------------------------------------------

struct AmountCase {
  std::int64_t target;
  std::int64_t speed;
  bool is_limited;
};

TEST(VelocityMode, The6046hAmountsBoundEverySpeedBut0) {
  for (const AmountCase& row :
       {AmountCase{50, 100, true}, AmountCase{-50, -100, true}, AmountCase{0, 0, false},
        AmountCase{100, 100, false}, AmountCase{-150, -150, false}, AmountCase{200, 200, false},
        AmountCase{500, 200, true}, AmountCase{-32'768, -200, true}}) {
    SCOPED_TRACE(row.target);
    AxisUnderTest axis;
    axis.write("vl_velocity_min_amount", 100);
    axis.write("vl_velocity_max_amount", 200);
    enable_vl(axis);
    axis.write("vl_target_velocity", row.target);
    axis.command(kRunRamp);
    axis.step(500);
    EXPECT_EQ(axis.read("vl_velocity_demand"), row.speed);
    EXPECT_EQ(axis.limit_active(), row.is_limited);
    EXPECT_TRUE(axis.reached()) << "the input of the ramp";
    EXPECT_EQ(axis.read("vl_target_velocity"), row.target) << "the value is not altered";
  }
}

TEST(VelocityMode, TheUpperAmountWinsOverALowerOneAboveIt) {
  AxisUnderTest axis;
  axis.write("vl_velocity_min_amount", 400);
  axis.write("vl_velocity_max_amount", 200);
  enable_vl(axis);
  axis.write("vl_target_velocity", 100);
  axis.command(kRunRamp);
  axis.step(300);
  EXPECT_EQ(axis.read("vl_velocity_demand"), 200);
}

TEST(VelocityMode, 607FhBoundsTheSpeedAndBit11ShowsIt) {
  AxisUnderTest axis;
  axis.write("vl_velocity_max_amount", 10'000);
  axis.write("app_speed_limit", 6'827);
  enable_vl(axis);
  axis.write("vl_target_velocity", 3'000);
  axis.command(kRunRamp);
  axis.step(300);
  EXPECT_EQ(axis.demand_velocity(), 6'827);
  EXPECT_EQ(axis.read("vl_velocity_demand"), 100) << "6827 x 60 / 4096 = 100.005";
  EXPECT_TRUE(axis.limit_active());
  axis.write("vl_target_velocity", 90);
  axis.step(300);
  EXPECT_FALSE(axis.limit_active());
}

TEST(VelocityMode, ALimitSwitchStopsWith604AhAndOnlyANew6042hStartsAgain) {
  for (const int sign : {1, -1}) {
    SCOPED_TRACE(sign);
    const char* const input = sign > 0 ? "test_positive_limit_input" : "test_negative_limit_input";
    AxisUnderTest axis;
    ASSERT_NO_FATAL_FAILURE(turn_at_300(axis, sign));
    axis.write(input, 1);
    axis.step(10);
    EXPECT_EQ(axis.demand_velocity(), sign * (kSpeedOf300 - 4'096));
    EXPECT_TRUE(axis.limit_active());
    axis.step(300);
    EXPECT_EQ(axis.demand_velocity(), 0);
    EXPECT_FALSE(axis.reached());
    axis.write("vl_target_velocity", sign * 200);
    axis.step(100);
    EXPECT_EQ(axis.demand_velocity(), 0) << "not into the switch";
    axis.write(input, 0);
    axis.step(100);
    EXPECT_EQ(axis.demand_velocity(), 0) << "nothing resumes when the switch opens";
    axis.write("vl_target_velocity", sign * 300);
    axis.step(300);
    EXPECT_EQ(axis.demand_velocity(), sign * kSpeedOf300);
  }
}

TEST(VelocityMode, ALockedRampStopsAtALimitSwitch) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(turn_at_300(axis));
  axis.command(0x005F);
  axis.write("test_positive_limit_input", 1);
  axis.step(300);
  EXPECT_EQ(axis.demand_velocity(), 0);
}

// ---- status bits -------------------------------------------------------------------------------

TEST(VelocityMode, Bit10ShowsTheInputOfTheRampIn606DhFor606Eh) {
  AxisUnderTest axis;
  set_vl_ramps(axis);
  axis.write("velocity_window", 500);
  axis.write("velocity_window_time", 30);
  enable_vl(axis);
  EXPECT_TRUE(axis.reached()) << "at rest, and the input is 0";
  axis.write("vl_target_velocity", 300);
  axis.controlword(kRunRamp);
  std::uint64_t inside = 0;
  bool rose = false;
  for (int i = 0; i < 600; ++i) {
    axis.step();
    inside = std::abs(axis.velocity() - kSpeedOf300) <= 500 ? inside + 1 : 0;
    // In the 31st tick the speed has been inside for longer than 30 ms.
    ASSERT_EQ(axis.reached(), inside > 30) << i;
    rose = rose || axis.reached();
  }
  EXPECT_TRUE(rose);
  axis.write("vl_target_velocity", 400);
  axis.step();
  EXPECT_FALSE(axis.reached());
}

TEST(VelocityMode, HasNoBits12And13) {
  AxisUnderTest axis;
  axis.write("following_error_window", 0);
  ASSERT_NO_FATAL_FAILURE(turn_at_300(axis));
  EXPECT_EQ(axis.statusword() & 0x3000, 0);
  EXPECT_EQ(axis.statusword() & 0x006F, 0x0027);
  axis.command(0x000F);
  axis.step(300);
  EXPECT_EQ(axis.statusword(), 0x0637);
}

TEST(VelocityMode, NamesItsBits) {
  const auto mode = OperatingMode::velocity;
  EXPECT_EQ(to_string(mode), "velocity");
  EXPECT_EQ(controlword_bit_name(0x0010, mode), "enable ramp");
  EXPECT_EQ(controlword_bit_name(0x0020, mode), "unlock ramp");
  EXPECT_EQ(controlword_bit_name(0x0040, mode), "reference ramp");
  EXPECT_EQ(controlword_bit_name(0x0100, mode), "halt");
  EXPECT_EQ(statusword_bit_name(0x1000, mode), "bit 12");
}

// ---- halt and stops ----------------------------------------------------------------------------

class VelocityModeStop : public testing::TestWithParam<std::int64_t> {};

TEST_P(VelocityModeStop, HaltBrakesWithTheRampOf605DhAndTheTargetReturns) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    axis.write("halt_option_code", GetParam());
    ASSERT_NO_FATAL_FAILURE(turn_at_300(axis, sign));
    axis.controlword(kRunRamp | 0x0100);
    axis.step(10);
    EXPECT_EQ(axis.demand_velocity(), sign * (kSpeedOf300 - loss_by_option(GetParam())));
    EXPECT_FALSE(axis.reached()) << "still braking";
    axis.step(400);
    EXPECT_EQ(axis.statusword(), 0x0637) << "at rest bit 10 = 1";
    axis.command(kRunRamp);
    axis.step(300);
    EXPECT_EQ(axis.demand_velocity(), sign * kSpeedOf300);
  }
}

INSTANTIATE_TEST_SUITE_P(Options, VelocityModeStop, testing::Values(1, 2, 3, 4),
                         testing::PrintToStringParamName());

TEST(VelocityMode, AModeChangeBrakesWith604AhAtALimitSwitch) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(turn_at_300(axis));
  axis.write("op_mode_cmd", 1);
  axis.step(10);
  axis.write("test_positive_limit_input", 1);
  axis.step(10);
  EXPECT_NEAR(axis.demand_velocity(), kSpeedOf300 - 2'048 - 4'096, 1);
  axis.step(200);
  EXPECT_EQ(axis.read("op_mode_actual"), 1);
}

// ---- properties --------------------------------------------------------------------------------

/// Any target, ramp, word or limit at any time: the demand never changes by more than the steepest
/// ramp of the tick, 60C6h, allows.
TEST(VelocityMode, TheDemandNeverStepsInRandomSequences) {
  const std::uint64_t rounds = test::case_count(30, 2'000);
  constexpr std::array<std::uint16_t, 8> kWords{0x7F, 0x7F, 0x7F, 0x6F, 0x5F, 0x3F, 0x0F, 0x017F};
  for (std::uint64_t seed = 0; seed < rounds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    AxisUnderTest axis;
    set_vl_ramps(axis);
    enable_vl(axis);
    std::int32_t last = 0;
    for (int i = 0; i < 2'000; ++i) {
      if (random.one_in(40)) {
        switch (random.below(6)) {
          case 0:
            axis.controlword(kWords.at(random.below(kWords.size())));
            break;
          case 1:
            axis.write("vl_acceleration_delta_speed",
                       static_cast<std::int64_t>(1 + random.below(10'000)));
            break;
          case 2:
            axis.write("vl_deceleration_delta_time",
                       static_cast<std::int64_t>(1 + random.below(10)));
            break;
          case 3:
            axis.write("vl_velocity_min_amount", static_cast<std::int64_t>(random.below(500)));
            break;
          case 4:
            axis.write("test_positive_limit_input", static_cast<std::int64_t>(random.below(2)));
            break;
          default:
            axis.write("vl_target_velocity", static_cast<std::int16_t>(random.word()));
            break;
        }
      }
      axis.step();
      ASSERT_LE(std::abs(axis.demand_velocity() - last), 801) << "tick " << i;
      ASSERT_LE(std::abs(axis.demand_velocity()), 136'533);
      last = axis.demand_velocity();
    }
  }
}

}  // namespace
}  // namespace vdrive
