// SPDX-License-Identifier: Apache-2.0
// Statements of the manual that no other test of the core covers; docs/reference/conformance.md
// lists them. Numbers are the manual's or follow from its formulas.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <string>
#include <tuple>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

/// 6081h, 6083h, 6084h.
void set_profile(AxisUnderTest& axis, std::int64_t velocity, std::int64_t acceleration,
                 std::int64_t deceleration) {
  axis.write("profile_velocity", velocity);
  axis.write("profile_acc", acceleration);
  axis.write("profile_dec", deceleration);
}

/// Runs until bit 10 is set; fails the test if it is not.
void run_to_target(AxisUnderTest& axis, std::uint64_t deadline = 30'000) {
  EXPECT_NE(axis.step_until_reached(deadline), 0U) << "bit 10 did not come";
}

/// Brings a fresh axis into `state`. The stops of Quick stop active and Fault reaction active take
/// a second, so that the axis is still in these states.
void bring_to(AxisUnderTest& axis, PowerState state) {
  if (state == not_ready_to_switch_on) {
    axis.axis().power_cycle();
    return;
  }
  axis.write("quick_stop_deceleration", 60'000);
  axis.step();
  if (state == switch_on_disabled) return;
  axis.command(0x0006);
  if (state == ready_to_switch_on) return;
  axis.command(0x0007);
  if (state == switched_on) return;
  axis.enable();
  if (state == operation_enabled) return;
  axis.write("position_user_target_value", 1'000'000);
  axis.command(0x001F);
  axis.step(300);
  if (state == quick_stop_active) {
    axis.command(0x0002);
    return;
  }
  axis.write("test_over_current", 1);
  axis.step();
  if (state == fault) axis.step(2'000);
}

constexpr std::array<PowerState, 8> kStates{
    not_ready_to_switch_on, switch_on_disabled, ready_to_switch_on,    switched_on,
    operation_enabled,      quick_stop_active,  fault_reaction_active, fault};

// ---- the tables of objects ---------------------------------------------------------------------

TEST(Manual, EveryWritableObjectAcceptsAWriteInEveryState) {
  // Column DriveStatus: "Any Status" in each writable row.
  for (const PowerState state : kStates) {
    AxisUnderTest there;
    ASSERT_NO_FATAL_FAILURE(bring_to(there, state));
    ASSERT_EQ(there.axis().power_state(), state);
    for (const ObjectDescription& object : kObjectTable) {
      if (object.origin != Origin::manual || object.access == Access::read_only) continue;
      AxisUnderTest axis = there;
      EXPECT_EQ(axis.axis().write(object.address, object.default_value), AbortCode::none)
          << object.variable_name << " in " << to_string(state);
      EXPECT_EQ(axis.axis().read(object.address).value, object.default_value);
    }
  }
}

// ---- controlword -------------------------------------------------------------------------------

/// Statusword and demand of each tick of a complete run, with `extra` set in every controlword.
std::vector<std::tuple<std::uint16_t, std::int32_t>> life_with(std::uint16_t extra) {
  AxisUnderTest axis;
  axis.write("op_mode_cmd", 1);
  axis.write("position_user_target_value", 2'000);
  std::vector<std::tuple<std::uint16_t, std::int32_t>> seen;
  for (const unsigned word : {0x0006U, 0x000FU, 0x003FU, 0x010FU, 0x003FU, 0x000FU, 0x007FU,
                              0x0007U, 0x000FU, 0x001FU, 0x0006U, 0x0005U}) {
    axis.controlword(static_cast<std::uint16_t>(word | extra));
    for (int i = 0; i < 60; ++i) {
      axis.step();
      seen.emplace_back(axis.statusword(), axis.demand());
    }
  }
  return seen;
}

TEST(Manual, ReservedAndVendorBitsOfTheControlwordChangeNothing) {
  // Bits 9 and 10 are reserved, 11 to 15 are vendor-specific.
  const auto plain = life_with(0);
  for (int bit = 9; bit <= 15; ++bit) {
    EXPECT_EQ(life_with(static_cast<std::uint16_t>(1U << bit)), plain) << "bit " << bit;
  }
  EXPECT_EQ(life_with(0xFE00), plain);
}

TEST(Manual, EnablingFromSwitchOnDisabledCanBeTurnedOff) {
  // The manual's row "0x0F: Switch on disabled -> Operation enabled" is the default; a master that
  // tests the strict standard turns it off and goes through 0x06.
  AxisConfiguration configuration;
  configuration.settings.enable_from_switch_on_disabled = false;
  AxisUnderTest axis(configuration);
  axis.write("op_mode_cmd", 1);
  EXPECT_EQ(axis.command(0x000F), 0x0250);
  EXPECT_EQ(axis.step(10), 0x0250);
  EXPECT_EQ(axis.command(0x0006), 0x0231);
  EXPECT_EQ(axis.command(0x000F), 0x0637);
}

// ---- mode --------------------------------------------------------------------------------------

TEST(Manual, TheModeChangesAt1637AndBit12IsLowOnReentry) {
  // 0x1637 is shown at rest although bit 4 of the controlword is still 1; entering the mode is not
  // an edge of bit 4.
  AxisUnderTest axis;
  axis.enable();
  axis.write("position_user_target_value", 1'000);
  axis.command(0x003F);
  run_to_target(axis);
  axis.step(100);
  ASSERT_EQ(axis.statusword(), 0x1637);
  axis.write("op_mode_cmd", 0);
  EXPECT_EQ(axis.step(), 0x0237) << "the empty mode has no mode bits";
  EXPECT_EQ(axis.read("op_mode_actual"), 0);
  axis.write("position_user_target_value", 5'000);
  axis.write("op_mode_cmd", 1);
  EXPECT_EQ(axis.step(), 0x0637);
  EXPECT_EQ(axis.read("op_mode_actual"), 1);
  EXPECT_EQ(axis.step(100), 0x0637);
  EXPECT_EQ(axis.demand(), 1'000);
}

// ---- statusword and 3005h ----------------------------------------------------------------------

TEST(Manual, TheMotorIsEnabledInOperationEnabledAndQuickStopActiveOnly) {
  // Table of 3005h. It does not list Fault reaction active: the motor brakes, so it is enabled.
  for (const PowerState state : kStates) {
    AxisUnderTest axis;
    ASSERT_NO_FATAL_FAILURE(bring_to(axis, state));
    ASSERT_EQ(axis.axis().power_state(), state);
    const bool enabled =
        state == operation_enabled || state == quick_stop_active || state == fault_reaction_active;
    EXPECT_EQ(axis.read("motor_op_status"), enabled ? 1 : 0) << to_string(state);
  }
}

TEST(Manual, EveryStateShowsVoltageAndRemoteAndNoReservedBit) {
  // Bits 4 and 9 are 1 in every statusword that the manual prints; 8, 14 and 15 are reserved.
  for (const PowerState state : kStates) {
    AxisUnderTest axis;
    ASSERT_NO_FATAL_FAILURE(bring_to(axis, state));
    const std::uint16_t word = axis.statusword();
    EXPECT_EQ(word & 0xC100U, 0U) << to_string(state);
    EXPECT_EQ(word & 0x0200U, 0x0200U) << to_string(state);
    if (state != not_ready_to_switch_on) {  // the DC link is not known yet
      EXPECT_EQ(word & 0x0010U, 0x0010U) << to_string(state);
    }
  }
}

// ---- 607Ah -------------------------------------------------------------------------------------

TEST(Manual, AnAbsoluteTargetIsApproachedFromWhicheverSideTheAxisStands) {
  // From a 6064h above 607Ah the axis moves in negative direction, from below in positive
  // direction, whatever the signs of the two.
  for (const auto& [from, to] :
       {std::tuple{-3'000, -1'000}, std::tuple{-3'000, 2'000}, std::tuple{3'000, 1'000},
        std::tuple{3'000, -2'000}, std::tuple{-1'000, -3'000}, std::tuple{1'000, 3'000}}) {
    AxisConfiguration configuration;
    configuration.initial_position = from;
    AxisUnderTest axis(configuration);
    axis.enable();
    axis.write("position_user_target_value", to);
    axis.controlword(0x003F);
    const int sign = to > from ? 1 : -1;
    while (axis.demand() != to && axis.ticks() < 10'000) {
      axis.step();
      ASSERT_GE(axis.demand_velocity() * sign, 0) << from << " -> " << to;
    }
    EXPECT_EQ(axis.demand(), to);
  }
}

TEST(Manual, TheSignOfARelativeTargetGivesTheDirection) {
  for (const std::int32_t from : {-20'000, 0, 20'000}) {
    for (const std::int32_t distance : {5'000, -5'000}) {
      AxisConfiguration configuration;
      configuration.initial_position = from;
      AxisUnderTest axis(configuration);
      axis.enable();
      axis.write("position_user_target_value", distance);
      axis.controlword(0x007F);
      const int sign = distance > 0 ? 1 : -1;
      while (axis.demand() != from + distance && axis.ticks() < 10'000) {
        axis.step();
        ASSERT_GE(axis.demand_velocity() * sign, 0) << distance << " from " << from;
      }
      EXPECT_EQ(axis.demand(), from + distance);
    }
  }
}

TEST(Manual, ThePositioningOptionCodeMattersToRelativeMovesOnly) {
  for (const std::int64_t option : {0, 1, 2}) {
    AxisUnderTest axis;
    axis.write("positioning_option_code", option);
    axis.enable();
    axis.write("position_user_target_value", 20'000);
    axis.command(0x003F);
    axis.step(100);  // during the move, so that target, demand and actual position differ
    ASSERT_NE(axis.demand(), 20'000);
    axis.write("position_user_target_value", 7'000);
    axis.command(0x000F);
    axis.command(0x003F);
    run_to_target(axis);
    EXPECT_EQ(axis.demand(), 7'000) << "60F2h = " << option;
  }
}

// ---- 607Dh -------------------------------------------------------------------------------------

TEST(Manual, TheAxisWarnsBeyondEitherSoftwareLimit) {
  for (const int sign : {1, -1}) {
    AxisConfiguration configuration;
    configuration.initial_position = sign * 8'000;
    AxisUnderTest axis(configuration);
    axis.write("user_position_lower_limit", -5'000);
    axis.write("user_position_upper_limit", 5'000);
    EXPECT_EQ(axis.step(), 0x0250) << "3535h = 0";
    axis.write("app_position_limit_switch", 1);
    EXPECT_EQ(axis.step(), 0x0AD0) << "0x250 with bit 11 and bit 7, not homed";
  }
}

// ---- speed -------------------------------------------------------------------------------------

/// Highest |606Ch| within a second of a move with the given 6081h and the default ramps.
std::int32_t top_speed(AxisUnderTest& axis, std::int64_t velocity) {
  axis.write("profile_velocity", velocity);
  axis.enable();
  axis.write("position_user_target_value", 400'000);
  axis.command(0x003F);
  std::int32_t highest = 0;
  for (int i = 0; i < 1'000; ++i) {
    axis.step();
    EXPECT_LE(axis.demand_velocity(), velocity);
    highest = std::max(highest, std::abs(axis.velocity()));
  }
  return highest;
}

TEST(Manual, TheActualSpeedDoesNotExceedTheProfileVelocity) {
  for (const std::int64_t velocity : {10'000, 68'267, 120'000}) {
    AxisUnderTest axis;
    const std::int32_t highest = top_speed(axis, velocity);
    EXPECT_GT(highest, velocity * 99 / 100) << velocity;
    // 1 %: the loops overshoot at the end of the ramp.
    EXPECT_LE(highest, velocity * 101 / 100) << velocity;
  }
}

TEST(Manual, TheSpeedLimitBoundsTheActualSpeed) {
  // 6081h = 200000 > 607Fh: the axis runs at 607Fh and 6081h keeps its value.
  for (const std::int64_t limit : {136'533, 50'000}) {
    AxisUnderTest axis;
    axis.write("app_speed_limit", limit);
    const std::int32_t highest = top_speed(axis, 200'000);
    EXPECT_GT(highest, limit * 99 / 100);
    EXPECT_LE(highest, limit * 101 / 100);
    EXPECT_EQ(axis.read("profile_velocity"), 200'000);
  }
}

// ---- acceleration and deceleration -------------------------------------------------------------

/// Ticks from the set-point until 606Bh is the profile velocity of 10000/s, and from a halt to 0.
struct RampTimes {
  std::uint64_t up;
  std::uint64_t down;
};

RampTimes ramp_times(AxisUnderTest& axis) {
  axis.write("profile_velocity", 10'000);
  axis.enable();
  axis.write("position_user_target_value", 1'000'000);
  axis.controlword(0x003F);
  RampTimes times{};
  times.up = axis.step_until(
      [&axis] {
        return axis.demand_velocity() == 10'000;
      },
      20'000);
  axis.controlword(0x010F);
  times.down = axis.step_until(
      [&axis] {
        return axis.demand_velocity() == 0;
      },
      20'000);
  return times;
}

TEST(Manual, AGreaterRampReachesTheSpeedSooner) {
  // t = v/a: 10000/20000 = 0.5 s and 10000/40000 = 0.25 s.
  for (const auto& [ramp, ticks] : {std::tuple{20'000, 500U}, std::tuple{40'000, 250U}}) {
    AxisUnderTest faster_up;
    faster_up.write("profile_acc", ramp);
    EXPECT_EQ(ramp_times(faster_up).up, ticks);
    AxisUnderTest faster_down;
    faster_down.write("profile_dec", ramp);
    EXPECT_EQ(ramp_times(faster_down).down, ticks);
  }
}

TEST(Manual, ARampAboveItsLimitRunsAtTheLimit) {
  // 6083h <= 60C5h and 6084h <= 60C6h: at 40000 and at 80000 both ramps take 10000/40000 = 0.25 s.
  for (const std::int64_t ramp : {40'000, 80'000}) {
    AxisUnderTest axis;
    axis.write("app_acc_limit", 40'000);
    axis.write("app_dec_limit", 40'000);
    axis.write("profile_acc", ramp);
    axis.write("profile_dec", ramp);
    const RampTimes times = ramp_times(axis);
    EXPECT_EQ(times.up, 250U) << ramp;
    EXPECT_EQ(times.down, 250U) << ramp;
  }
}

TEST(Manual, ADecelerationLimitOf0CountsAs1) {
  for (const char* const object : {"app_dec_limit", "profile_dec"}) {
    AxisUnderTest axis;
    axis.enable();
    axis.write("profile_velocity", 1'000);
    axis.write("position_user_target_value", 10'000'000);
    axis.command(0x003F);
    axis.step(100);
    ASSERT_EQ(axis.demand_velocity(), 1'000);
    axis.write(object, 0);
    axis.controlword(0x010F);
    axis.step(2'000);  // 2 s at 1/s²
    EXPECT_EQ(axis.demand_velocity(), 998) << object;
  }
}

TEST(Manual, TheExampleRunsWithTheDefaultRamps) {
  // Rows 5 and 6: "the default value will do". 10000 at 1000/s and 409600/s²: 10 s +
  // 1000/409600 = 10.00244 s, tick 10003.
  AxisUnderTest axis;
  axis.enable();
  axis.write("profile_velocity", 1'000);
  axis.write("position_user_target_value", 10'000);
  axis.controlword(0x003F);
  EXPECT_EQ(axis.step_until_status(0xFFFF, 0x1637, 20'000), 10'003U);
  EXPECT_EQ(axis.demand(), 10'000);
}

TEST(Manual, TheNegativeExampleStartsEnabledOrFromReadyToSwitchOn) {
  for (const bool enabled : {true, false}) {
    AxisUnderTest axis;
    axis.enable();
    set_profile(axis, 5'000, 60'000, 60'000);
    if (!enabled) {
      ASSERT_EQ(axis.command(0x0006), 0x0231);
    }
    axis.write("position_user_target_value", -10'000);
    EXPECT_EQ(axis.command(0x000F), 0x0637);
    EXPECT_EQ(axis.command(0x003F), 0x1237);
    run_to_target(axis);
    EXPECT_EQ(axis.statusword(), 0x1637);
    EXPECT_EQ(axis.demand(), -10'000);
  }
}

// ---- torque and current ------------------------------------------------------------------------

TEST(Manual, TheCurrentStaysBetweenBothTorqueLimits) {
  // -60E1h <= 6078h <= 60E0h in each tick, with a load that needs more on either side.
  AxisUnderTest axis;
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.write("positive_torque_limit_relative", 150);
  axis.write("negative_torque_limit_relative", 250);
  axis.enable();
  std::int32_t lowest = 0;
  std::int32_t highest = 0;
  for (const std::int64_t load : {-3'000, 3'000}) {  // mN.m; rated 3000, so 1000 per mille hold it
    axis.write("test_load_torque", load);
    for (int i = 0; i < 200; ++i) {
      axis.step();
      ASSERT_LE(axis.status().current_actual_value, 150);
      ASSERT_GE(axis.status().current_actual_value, -250);
      lowest = std::min<std::int32_t>(lowest, axis.status().current_actual_value);
      highest = std::max<std::int32_t>(highest, axis.status().current_actual_value);
    }
  }
  EXPECT_EQ(highest, 150);
  EXPECT_EQ(lowest, -250);
}

TEST(Manual, TheTorqueLimitsAreRelativeToTheRatedTorqueOnBothSides) {
  // The examples of 60E0h and 60E1h: 6076h = 3000 mN.m and 10 %, which is 100 per mille: 300 mN.m.
  for (const int sign : {1, -1}) {
    AxisConfiguration configuration;
    configuration.model.viscous_friction = 0.0;
    configuration.model.coulomb_friction = 0.0;
    AxisUnderTest axis(configuration);
    axis.write("following_error_window", 0xFFFFFFFF);
    axis.write("motor_rated_torque", 3'000);
    axis.write(sign > 0 ? "positive_torque_limit_relative" : "negative_torque_limit_relative", 100);
    set_profile(axis, 136'533, 0xFFFFFFFF, 0xFFFFFFFF);
    axis.enable();
    axis.write("position_user_target_value", sign * 2'000'000'000);
    axis.command(0x003F);
    axis.step(50);
    EXPECT_EQ(axis.read("torque_actual_value"), sign * 100);
    const std::int32_t first = axis.velocity();
    axis.step(100);
    // 0.3 N.m on 6e-4 kg.m2: 500 rad/s², over 0.1 s 50 rad/s = 50·4096/2π = 32595 units/s.
    EXPECT_NEAR((axis.velocity() - first) * sign, 32'595, 2);
  }
}

TEST(Manual, ATorqueLimitOf0IsOff) {
  // 0 switches the limit off: the same load is then held at rest with the torque that it needs.
  AxisUnderTest axis;
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.enable();
  for (const std::int64_t limit : {100, 0}) {
    axis.write("positive_torque_limit_relative", limit);
    axis.write("negative_torque_limit_relative", limit);
    for (const int sign : {1, -1}) {
      axis.write("test_load_torque", sign * 1'500);  // half of the rated torque
      std::int32_t highest = 0;
      for (int i = 0; i < 100; ++i) {
        axis.step();
        highest = std::max<std::int32_t>(highest, std::abs(axis.status().torque_actual_value));
      }
      EXPECT_EQ(highest <= 100, limit == 100) << "limit " << limit << ", sign " << sign;
    }
  }
}

// ---- derived values ----------------------------------------------------------------------------

TEST(Manual, EachEncoderHasItsOwnPositionError) {
  // 3573h = 6062h - 3572h, 3575h = 606Bh - 3574h (encoder 1, motor); 60F4h = 6062h - 6064h,
  // 351Eh = 606Bh - 606Ch (encoder 2, load): on a soft shaft the two encoders differ.
  AxisConfiguration configuration;
  configuration.model.coupling = Coupling::two_inertia;
  configuration.model.coupling_stiffness = 50.0;
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.write("test_load_torque", 1'000);
  axis.write("position_user_target_value", 20'000);
  axis.command(0x003F);
  bool positions_differed = false;
  bool speeds_differed = false;
  for (int i = 0; i < 500; ++i) {
    axis.step();
    const AxisStatus& s = axis.status();
    positions_differed |= s.motor_position_actual_value != s.load_position_actual_value;
    speeds_differed |= s.motor_velocity_actual_value != s.load_velocity_actual_value;
    ASSERT_EQ(s.motor_position_error_value,
              s.position_demand_value - s.motor_position_actual_value);
    ASSERT_EQ(s.load_position_error_value, s.position_demand_value - s.load_position_actual_value);
    ASSERT_EQ(s.motor_velocity_error_value,
              s.velocity_demand_value - s.motor_velocity_actual_value);
    ASSERT_EQ(s.load_velocity_error_value, s.velocity_demand_value - s.load_velocity_actual_value);
  }
  EXPECT_TRUE(positions_differed);
  EXPECT_TRUE(speeds_differed);
}

TEST(Manual, TheCurrentErrorIsInMilliampere) {
  // (6074h - 6078h) per mille of 6075h: with 8000 mA each per mille is 8 mA.
  AxisUnderTest axis;
  axis.write("motor_rated_current", 8'000);
  axis.enable();
  axis.write("position_user_target_value", 50'000);
  axis.command(0x003F);
  bool differed = false;
  for (int i = 0; i < 500; ++i) {
    axis.step();
    const AxisStatus& s = axis.status();
    ASSERT_EQ(s.current_error_value, (s.torque_demand - s.current_actual_value) * 8);
    differed |= s.current_error_value != 0;
  }
  EXPECT_TRUE(differed);
}

}  // namespace
}  // namespace vdrive
