// SPDX-License-Identifier: Apache-2.0
// Option codes 605Ah to 605Eh and 6007h: the ramp, and the states during and after the stop.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <tuple>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

// Ramps that cannot be confused: from 40000/s they take 0.8 s, 0.4 s and 0.2 s.
constexpr std::int64_t kRampOf6084h = 50'000;
constexpr std::int64_t kRampOf6085h = 100'000;
constexpr std::int64_t kRampOf60C6h = 200'000;
constexpr std::int32_t kSpeed = 40'000;

/// Moving at constant speed, controlword 001Fh.
void start_moving(AxisUnderTest& axis) {
  axis.write("profile_acc", 1'000'000);
  axis.write("profile_dec", kRampOf6084h);
  axis.write("quick_stop_deceleration", kRampOf6085h);
  axis.write("app_dec_limit", kRampOf60C6h);
  axis.write("profile_velocity", kSpeed);
  axis.enable();
  axis.write("position_user_target_value", 10'000'000);
  axis.command(0x001F);
  axis.step(200);
  ASSERT_EQ(axis.demand_velocity(), kSpeed);
}

std::int64_t ramp_of_stop(std::int64_t option) {
  switch (option) {
    case 1:
      return kRampOf6084h;
    case 2:
      return kRampOf6085h;
    default:
      return kRampOf60C6h;
  }
}

/// Follows a braking axis while it stays in `state`: each tick reduces the speed by `ramp`/1000.
/// @return ticks until another state is shown, or until the axis has been at rest for 200 ticks.
std::uint64_t expect_braking(AxisUnderTest& axis, PowerState state, std::int64_t ramp) {
  const auto braking = static_cast<std::uint64_t>(kSpeed * 1'000 / ramp);
  for (std::uint64_t tick = 1; tick <= braking + 200; ++tick) {
    if (axis.state() != state) {
      EXPECT_GT(tick, braking) << "left " << to_string(state) << " before standstill";
      return tick;
    }
    if (tick <= braking) {
      const auto expected = kSpeed - static_cast<std::int64_t>(tick) * ramp / 1'000;
      EXPECT_NEAR(axis.demand_velocity(), static_cast<double>(expected), 1) << "tick " << tick;
      if (axis.demand_velocity() > expected + 1 || axis.demand_velocity() < expected - 1) return 0;
      EXPECT_EQ(axis.status().motor_op_status, 1);
    } else {
      EXPECT_EQ(axis.demand_velocity(), 0);
    }
    axis.step();
  }
  return braking + 200;
}

// ---- 605Ah -------------------------------------------------------------------------------------

class QuickStop : public testing::TestWithParam<std::int64_t> {};

TEST_P(QuickStop, BrakesWithTheRampOfItsOptionAndThenLeavesTheStateOrStays) {
  const std::int64_t option = GetParam();
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", option);
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));

  EXPECT_EQ(axis.command(0x0002), 0x0217);
  expect_braking(axis, quick_stop_active, ramp_of_stop(option > 4 ? option - 4 : option));

  if (option <= 4) {
    EXPECT_EQ(axis.statusword(), 0x0250);
    EXPECT_EQ(axis.status().motor_op_status, 0);
  } else {
    EXPECT_EQ(axis.statusword(), 0x0617) << "standing, still powered";
    EXPECT_EQ(axis.status().motor_op_status, 1);
  }
}

INSTANTIATE_TEST_SUITE_P(StopOptions, QuickStop, testing::Values(1, 2, 3, 4, 5, 6, 7, 8),
                         testing::PrintToStringParamName());

TEST(StopOptions, AQuickStopAtRestShowsItsStateForAtLeastOneTick) {
  for (std::int64_t option = 0; option <= 4; ++option) {
    AxisUnderTest axis;
    axis.write("quick_stop_option_code", option);
    axis.enable();
    axis.command(0x0002);
    EXPECT_EQ(axis.state(), quick_stop_active) << option;
    EXPECT_NE(axis.step_until_status(0x004F, 0x0040, 3), 0U) << option;
  }
}

TEST(StopOptions, TheQuickStopDwellHoldsTheStateForItsTime) {
  AxisConfiguration configuration;
  configuration.settings.quick_stop_dwell_ms = 50;
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.command(0x0002);
  EXPECT_EQ(axis.step(48), 0x0617);
  EXPECT_NE(axis.step_until_status(0x004F, 0x0040, 3), 0U);
}

TEST(StopOptions, TheQuickRampIsCappedBy60C6hAnd0CountsAs1) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.write("quick_stop_deceleration", 1'000'000);
  axis.command(0x0002);
  expect_braking(axis, quick_stop_active, kRampOf60C6h);

  AxisUnderTest slow;
  ASSERT_NO_FATAL_FAILURE(start_moving(slow));
  slow.write("quick_stop_deceleration", 0);
  slow.command(0x0002);
  slow.step(1'999);
  EXPECT_EQ(slow.demand_velocity(), kSpeed - 2);
}

TEST(StopOptions, QuickStopDropsTheMoveAndReEnablingDoesNotRestartIt) {
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 6);
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0002);
  axis.step(600);
  ASSERT_EQ(axis.statusword(), 0x0617);

  EXPECT_EQ(axis.command(0x000F), 0x0637) << "T16";
  const std::int32_t rest = axis.demand();
  axis.step(500);
  EXPECT_EQ(axis.demand(), rest);
  EXPECT_EQ(axis.statusword(), 0x0637);
}

TEST(StopOptions, ReEnablingDuringTheQuickStopBringsTheAxisToRest) {
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 6);
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0002);
  axis.step(100);
  EXPECT_EQ(axis.command(0x000F), 0x0237);
  EXPECT_NE(axis.step_until_reached(2'000), 0U);
  EXPECT_EQ(axis.demand_velocity(), 0);
  const std::int32_t rest = axis.demand();
  axis.step(500);
  EXPECT_EQ(axis.demand(), rest);
}

TEST(StopOptions, ReEnablingPowersACoastingAxis) {
  // 605Ah = 0 removes the power; 5 to 8, written before the state is left, allow transition 16.
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 0);
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0002);
  ASSERT_EQ(axis.status().motor_op_status, 0);
  axis.write("quick_stop_option_code", 6);
  axis.step(20);
  ASSERT_EQ(axis.state(), quick_stop_active);

  axis.command(0x000F);

  EXPECT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.status().motor_op_status, 1);
  axis.step(1'000);
  EXPECT_EQ(axis.statusword(), 0x0637);
  EXPECT_EQ(axis.actual(), axis.demand()) << "held where control was taken";
}

TEST(StopOptions, ReEnablingAfterAModeChangeInTheQuickStopShowsNoTargetReachedInMotion) {
  // With equal ramps the stop continues unchanged; with the window off, bit 10 shows the end of the
  // motion.
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 6);
  axis.write("position_target_reached_window", 0xFFFFFFFF);
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.write("quick_stop_deceleration", kRampOf6084h);
  axis.command(0x0002);
  axis.step(100);
  axis.write("op_mode_cmd", 0);
  axis.write("op_mode_cmd", 1);
  axis.controlword(0x000F);
  for (int tick = 0; tick < 2'000; ++tick) {
    axis.step();
    ASSERT_TRUE(axis.demand_velocity() == 0 || !axis.reached()) << "tick " << tick;
  }
  EXPECT_EQ(axis.statusword(), 0x0637);
}

TEST(StopOptions, ReEnablingWith0x1FDoesNotTakeTheHeldBit4AsASetPoint) {
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 6);
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0002);
  axis.step(600);
  EXPECT_EQ(axis.command(0x001F), 0x0637) << "Operation enabled must hold before the word";
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
}

TEST(StopOptions, DisableVoltageInAQuickStopRemovesThePowerAtOnce) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0002);
  axis.step(50);
  EXPECT_EQ(axis.command(0x0000), 0x0250);
  EXPECT_EQ(axis.status().motor_op_status, 0);
  EXPECT_GT(axis.velocity(), 10'000) << "coasting";
}

TEST(StopOptions, AnUnchangedEnableOperationDoesNotReEnableAfterTheQuickStop) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0002);
  axis.command(0x000F);
  EXPECT_NE(axis.step_until_status(0x004F, 0x0040, 2'000), 0U);
  EXPECT_EQ(axis.step(100), 0x0250);
}

// ---- 605Bh and 605Ch ---------------------------------------------------------------------------

TEST(StopOptions, EnableOperationDoesNotCancelARampInProgress) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0007);
  axis.command(0x000F);
  EXPECT_NE(axis.step_until_status(0x006F, 0x0023, 2'000), 0U);
}

TEST(StopOptions, StrongerCommandsActDuringTheRamp) {
  for (const auto& [word, state] :
       {std::pair{0x0000, switch_on_disabled}, std::pair{0x0002, quick_stop_active},
        std::pair{0x0006, ready_to_switch_on}}) {
    AxisUnderTest axis;  // 605Bh = 0: shutdown acts immediately
    ASSERT_NO_FATAL_FAILURE(start_moving(axis));
    axis.command(0x0007);
    axis.step(100);
    axis.command(static_cast<std::uint16_t>(word));
    EXPECT_EQ(axis.state(), state) << std::hex << word;
  }
}

TEST(StopOptions, NoSetPointIsAcceptedDuringTheRamp) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0007);
  axis.step(100);
  axis.command(0x0017);
  axis.command(0x0007);
  axis.command(0x001F);
  EXPECT_EQ(axis.status().ignored_set_points, 2U);
  EXPECT_NE(axis.step_until_status(0x006F, 0x0023, 2'000), 0U);
}

// ---- 605Dh -------------------------------------------------------------------------------------

class HaltOption : public testing::TestWithParam<std::int64_t> {};

TEST_P(HaltOption, BrakesWithItsRampAndStaysInOperationEnabled) {
  AxisUnderTest axis;
  axis.write("halt_option_code", GetParam());
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  EXPECT_EQ(axis.command(0x010F), 0x0237);
  expect_braking(axis, operation_enabled, ramp_of_stop(GetParam()));
  EXPECT_EQ(axis.statusword(), 0x0637);
}

INSTANTIATE_TEST_SUITE_P(StopOptions, HaltOption, testing::Values(1, 2, 3, 4),
                         testing::PrintToStringParamName());

// ---- 605Eh -------------------------------------------------------------------------------------

/// A cause of a fault, its code, and whether the axis can still brake.
struct FaultCause {
  const char* name;
  const char* input;  // test bench input; empty for the silent master
  std::int64_t code;
  bool brakes;
};

constexpr std::array<FaultCause, 7> kFaultCauses{{
    {"over_current", "test_over_current", 0x2310, true},
    {"over_temperature", "test_over_temperature", 0x4310, true},
    {"following_error", "test_blocked_load", 0x8611, true},
    {"silent_master", "", 0x8130, true},
    {"connection_loss", "test_connection_loss", 0x8130, true},
    {"encoder_failure", "test_encoder_failure", 0x7305, false},
    {"dc_link_loss", "test_dc_link_loss", 0x3220, false},
}};

class FaultReaction : public testing::TestWithParam<std::tuple<FaultCause, std::int64_t>> {
 protected:
  /// Triggers the cause. @return false if no fault follows within the next ticks.
  bool provoke() {
    const FaultCause& cause = std::get<0>(GetParam());
    if (*cause.input == '\0') {
      axis.axis().report_connection_loss();
    } else {
      axis.write(cause.input, 1);
    }
    return axis.step_until_state(fault_reaction_active, 200) != 0;
  }

  AxisUnderTest axis;
};

TEST_P(FaultReaction, Follows605EhForCausesThatCanBrakeAndCoastsForOthers) {
  const auto& [cause, option] = GetParam();
  axis.write("fault_reaction_option_code", option);
  axis.write("following_error_window", 2'000);  // at 40000/s a blocked axis exceeds it in 50 ms
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  ASSERT_TRUE(provoke());
  EXPECT_EQ(axis.read("error_code"), cause.code);
  const bool following_error = cause.code == 0x8611;
  // Bit 13 with a following error; no bit 4 without the DC link.
  const auto bits = static_cast<std::uint16_t>((following_error ? 0x2000 : 0) |
                                               (cause.code == 0x3220 ? 0 : 0x0010));
  EXPECT_EQ(axis.statusword(), 0x020F | bits);

  if (option == 0 || !cause.brakes) {
    EXPECT_EQ(axis.status().motor_op_status, 0);
    EXPECT_EQ(axis.step(), 0x0208 | bits) << "the reaction shows for one tick";
    EXPECT_TRUE(following_error || axis.velocity() > kSpeed - 2'000) << "coasting";
    return;
  }
  if (following_error) {
    axis.step();  // detected after the demand of its tick: the ramp begins in the next
  }
  expect_braking(axis, fault_reaction_active, ramp_of_stop(option));
  EXPECT_EQ(axis.statusword(), 0x0208 | bits);
  EXPECT_EQ(axis.status().motor_op_status, 0);
}

INSTANTIATE_TEST_SUITE_P(StopOptions, FaultReaction,
                         testing::Combine(testing::ValuesIn(kFaultCauses),
                                          testing::Values(0, 1, 2, 3, 4)),
                         [](const auto& row) {
                           return std::string(std::get<0>(row.param).name) + "_605Eh_" +
                                  std::to_string(std::get<1>(row.param));
                         });

// ---- 6007h -------------------------------------------------------------------------------------

TEST(StopOptions, ALostMasterIsIgnoredWith6007hAt0) {
  AxisUnderTest axis;
  axis.write("abort_connection_option_code", 0);
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.axis().report_connection_loss();
  axis.step();
  EXPECT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.demand_velocity(), kSpeed);
}

TEST(StopOptions, ALostMasterIsAFaultByDefault) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.axis().report_connection_loss();
  EXPECT_EQ(axis.step(), 0x021F);
  EXPECT_EQ(axis.read("error_code"), 0x8130);
  EXPECT_EQ(axis.read("error_register") & 0x10, 0x10);
  expect_braking(axis, fault_reaction_active, kRampOf6085h);  // 605Eh = 2
  EXPECT_EQ(axis.statusword(), 0x0218);
  EXPECT_EQ(axis.step(1'000), 0x0218) << "latched, never resuming by itself";
  EXPECT_EQ(axis.command(0x0086), 0x0250);
}

TEST(StopOptions, ALostMasterDisablesVoltageWith6007hAt2) {
  AxisUnderTest axis;
  axis.write("abort_connection_option_code", 2);
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.axis().report_connection_loss();
  EXPECT_EQ(axis.step(), 0x0250);
  EXPECT_EQ(axis.read("error_code"), 0);
}

TEST(StopOptions, ALostMasterIsAQuickStopWith6007hAt3) {
  AxisUnderTest axis;
  axis.write("abort_connection_option_code", 3);
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.axis().report_connection_loss();
  EXPECT_EQ(axis.step(), 0x0217);
  expect_braking(axis, quick_stop_active, kRampOf6085h);
  EXPECT_EQ(axis.statusword(), 0x0250);
}

TEST(StopOptions, ALostMasterHasAnEffectOnlyWhileTheAxisIsControlled) {
  for (const std::int64_t option : {1, 2, 3}) {
    AxisUnderTest axis;
    axis.write("abort_connection_option_code", option);
    axis.axis().report_connection_loss();
    EXPECT_EQ(axis.step(), 0x0250) << option;
    axis.command(0x0006);
    axis.axis().report_connection_loss();
    EXPECT_EQ(axis.step(), 0x0231) << option;
    axis.command(0x0007);
    axis.axis().report_connection_loss();
    EXPECT_EQ(axis.step(), 0x0233) << option;
  }
}

// ---- a cyclic master ---------------------------------------------------------------------------

/// A master that writes 6040h in every tick must not delay the drive's own transitions.
std::uint64_t ticks_until(AxisUnderTest& axis, PowerState state, std::uint16_t word) {
  return axis.step_until(
      [&] {
        axis.controlword(word);
        return axis.state() == state;
      },
      3'000);
}

TEST(StopOptions, ARepeatedControlwordDoesNotDelayTheEndOfAQuickStop) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0002);
  EXPECT_NEAR(static_cast<double>(ticks_until(axis, switch_on_disabled, 0x0002)), 400.0, 100.0);
}

TEST(StopOptions, ARepeatedControlwordDoesNotDelayTheEndOfAFaultReaction) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.write("test_over_current", 1);
  axis.controlword(0x001F);
  axis.step();
  EXPECT_NEAR(static_cast<double>(ticks_until(axis, fault, 0x001F)), 400.0, 100.0);
}

TEST(StopOptions, ARepeatedControlwordDoesNotDelayTheEndOfADisableRamp) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0007);
  EXPECT_NEAR(static_cast<double>(ticks_until(axis, switched_on, 0x0007)), 800.0, 100.0);
}

TEST(StopOptions, RepeatedWritesOfRampsDoNotDelayTheEndOfAStop) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.command(0x0002);
  const std::uint64_t ticks = axis.step_until(
      [&axis] {
        axis.write("profile_dec", kRampOf6084h);
        axis.write("position_target_reached_window", 100);
        return axis.state() == switch_on_disabled;
      },
      3'000);
  EXPECT_NEAR(static_cast<double>(ticks), 400.0, 100.0);
}

TEST(StopOptions, ARepeatedControlwordDoesNotDelayAModeChangeInMotion) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.write("op_mode_cmd", 0);
  const std::uint64_t ticks = axis.step_until(
      [&axis] {
        axis.controlword(0x001F);
        return axis.read("op_mode_actual") == 0;
      },
      3'000);
  EXPECT_NEAR(static_cast<double>(ticks), 800.0, 100.0);
}

TEST(StopOptions, AStopWaitsAtMostASecondForStandstill) {
  // A threshold of 0 and an encoder of 4096 counts under a load: the speed hunts around zero.
  AxisConfiguration configuration;
  configuration.model.encoder_resolution = 4096.0;
  configuration.model.load_encoder_resolution = 4096.0;
  AxisUnderTest axis(configuration);
  axis.write("velocity_threshold", 0);
  ASSERT_NO_FATAL_FAILURE(start_moving(axis));
  axis.write("test_load_torque", 500);
  axis.command(0x0002);
  EXPECT_NE(axis.step_until_state(switch_on_disabled, 1'450), 0U);
}

}  // namespace
}  // namespace vdrive
