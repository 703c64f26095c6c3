// SPDX-License-Identifier: Apache-2.0
// Faults: cause, reaction, 603Fh, 1001h, 1003h, statusword, reset. Also limit switches, which are
// not faults.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <string>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

struct Cause {
  const char* name;
  const char* object;
  std::uint16_t code;
  std::uint16_t register_bit;  // of 1001h, in addition to the generic bit 0
};

std::string name_of_cause(const testing::TestParamInfo<Cause>& info) {
  return info.param.name;
}

void start_moving_to_fail(AxisUnderTest& axis) {
  axis.enable();
  axis.write("profile_velocity", 40'000);
  axis.write("position_user_target_value", 1'000'000);
  axis.command(0x003F);
  axis.step(300);
  ASSERT_EQ(axis.demand_velocity(), 40'000);
}

class InjectedFault : public testing::TestWithParam<Cause> {
 protected:
  void inject() { axis.write(GetParam().object, 1); }

  void remove() { axis.write(GetParam().object, 0); }

  void step_to_fault() { ASSERT_NE(axis.step_until_state(fault, 2'000), 0U); }

  AxisUnderTest axis;
};

TEST_P(InjectedFault, SetsItsBitOfTheErrorRegisterAndEntersTheHistory) {
  const Cause& cause = GetParam();
  axis.enable();
  inject();
  step_to_fault();
  EXPECT_EQ(axis.read("error_register") & cause.register_bit, cause.register_bit);
  EXPECT_EQ(axis.read("error_register") & 1, 1);
  EXPECT_EQ(axis.read("error_history_count"), 1);
  EXPECT_EQ(axis.read("error_history_1") & 0xFFFF, cause.code);
  EXPECT_EQ(axis.status().fault_count, 1U);
}

TEST_P(InjectedFault, IsNotResetWhileTheCauseLasts) {
  axis.enable();
  inject();
  step_to_fault();
  for (int i = 0; i < 3; ++i) {
    axis.command(0x0080);
    EXPECT_EQ(axis.state(), fault);
    axis.command(0x0000);
    EXPECT_EQ(axis.state(), fault);
  }
  remove();
  axis.step();
  EXPECT_EQ(axis.state(), fault) << "latched";
  EXPECT_EQ(axis.command(0x0080), 0x0250);
  EXPECT_EQ(axis.read("error_code"), 0) << "cleared with the reset";
  EXPECT_EQ(axis.read("error_register"), 0);
  EXPECT_EQ(axis.read("error_history_count"), 1) << "the history stays";
}

TEST_P(InjectedFault, CanBeResetInTheTickThatRemovesItsCause) {
  axis.enable();
  inject();
  step_to_fault();
  remove();
  axis.controlword(0x0086);
  EXPECT_EQ(axis.step(), 0x0250);
}

TEST_P(InjectedFault, DropsTheActiveMove) {
  ASSERT_NO_FATAL_FAILURE(start_moving_to_fail(axis));
  inject();
  axis.step();
  remove();
  step_to_fault();
  axis.step(2'000);
  EXPECT_EQ(axis.command(0x0086), 0x0250);
  EXPECT_EQ(axis.command(0x000F), 0x0637);
  const std::int32_t rest = axis.demand();
  axis.step(1'000);
  EXPECT_EQ(axis.demand(), rest);
  EXPECT_EQ(axis.statusword(), 0x0637);
}

INSTANTIATE_TEST_SUITE_P(
    Fault, InjectedFault,
    testing::Values(Cause{"over_current", "test_over_current", 0x2310, 1U << 1U},
                    Cause{"over_temperature", "test_over_temperature", 0x4310, 1U << 3U},
                    Cause{"encoder_failure", "test_encoder_failure", 0x7305, 1U << 5U},
                    Cause{"dc_link_loss", "test_dc_link_loss", 0x3220, 1U << 2U}),
    name_of_cause);

TEST(Fault, AFailureOfEitherEncoderIsAnEncoderFault) {
  for (const std::int64_t which : {1, 2}) {
    AxisUnderTest axis;
    axis.enable();
    axis.write("test_encoder_failure", which);
    axis.step(3);
    EXPECT_EQ(axis.read("error_code"), 0x7305);
  }
}

TEST(Fault, WithoutPowerShowsFaultReactionActiveForOneTick) {
  for (const std::uint16_t word : {std::uint16_t{0x0000}, std::uint16_t{0x0006}}) {
    AxisUnderTest axis;
    axis.command(word);
    axis.write("test_over_temperature", 1);
    EXPECT_EQ(axis.step(), 0x021F);
    EXPECT_EQ(axis.step(), 0x0218);
  }
}

TEST(Fault, TheHistoryKeepsTheNewestEightFirst) {
  AxisUnderTest axis;
  for (int i = 0; i < 10; ++i) {
    const char* const cause = i % 2 == 0 ? "test_over_current" : "test_over_temperature";
    axis.write(cause, 1);
    axis.step(3);
    axis.write(cause, 0);
    axis.command(0x0080);
    axis.command(0x0000);
  }
  EXPECT_EQ(axis.read("error_history_count"), 8);
  EXPECT_EQ(axis.read("error_history_1") & 0xFFFF, 0x4310);
  EXPECT_EQ(axis.read("error_history_2") & 0xFFFF, 0x2310);
  EXPECT_EQ(axis.read("error_history_8") & 0xFFFF, 0x2310);
  EXPECT_EQ(axis.status().fault_count, 10U);

  for (const std::int64_t value : {1, 8, 9, 255}) {
    EXPECT_EQ(axis.try_write("error_history_count", value), AbortCode{0x06090030}) << value;
  }
  EXPECT_EQ(axis.try_write("error_history_count", 256), AbortCode{0x06090031});
  EXPECT_EQ(axis.try_write("error_history_count", -1), AbortCode{0x06090032});
  EXPECT_EQ(axis.read("error_history_count"), 8);
  axis.write("error_history_count", 0);
  EXPECT_EQ(axis.read("error_history_count"), 0);
  EXPECT_EQ(axis.try_read("error_history_1").code, AbortCode{0x08000024});
}

TEST(Fault, FollowingErrorAndLostMasterEnterTheHistoryAndCanBeResetAtOnce) {
  AxisUnderTest axis;
  axis.write("following_error_window", 100);
  axis.enable();
  axis.write("test_blocked_load", 1);
  axis.write("position_user_target_value", 10'000);
  axis.command(0x003F);
  ASSERT_NE(axis.step_until_status(0x004F, 0x0008, 1'000), 0U);
  EXPECT_EQ(axis.read("error_history_count"), 1);
  EXPECT_EQ(axis.read("error_history_1"), 0x8611);
  EXPECT_EQ(axis.read("error_register"), 0x21);
  EXPECT_EQ(axis.command(0x0080), 0x0250) << "without power there is no following error";
  EXPECT_EQ(axis.read("error_register"), 0);

  axis.command(0x000F);
  axis.axis().report_connection_loss();
  ASSERT_NE(axis.step_until_status(0x004F, 0x0008, 1'000), 0U);
  EXPECT_EQ(axis.read("error_history_count"), 2);
  EXPECT_EQ(axis.read("error_history_1"), 0x8130);
  EXPECT_EQ(axis.read("error_history_2"), 0x8611);
  EXPECT_EQ(axis.read("error_register"), 0x11);
  EXPECT_EQ(axis.status().fault_count, 2U);
  EXPECT_EQ(axis.command(0x0080), 0x0250);
}

TEST(Fault, APartlyFilledHistoryHasNoDataBeyondItsCount) {
  AxisUnderTest axis;
  axis.write("test_over_current", 1);
  axis.step(3);
  EXPECT_EQ(axis.try_read("error_history_1").code, AbortCode::none);
  EXPECT_EQ(axis.try_read("error_history_2").code, AbortCode{0x08000024});
}

TEST(Fault, ASecondFaultWithBit7HeldNeedsANewEdge) {
  AxisUnderTest axis;
  axis.write("test_over_current", 1);
  axis.step(3);
  axis.write("test_over_current", 0);
  EXPECT_EQ(axis.command(0x0080), 0x0250);
  axis.write("test_over_current", 1);
  axis.step(3);
  axis.write("test_over_current", 0);
  EXPECT_EQ(axis.command(0x0080), 0x0218) << "1 -> 1 is no edge";
  EXPECT_EQ(axis.command(0x0000), 0x0218) << "1 -> 0 neither";
  EXPECT_EQ(axis.command(0x0080), 0x0250);
}

TEST(Fault, TheResetControlwordCarriesNoOtherCommand) {
  AxisUnderTest axis;
  axis.write("test_over_current", 1);
  axis.step(3);
  axis.write("test_over_current", 0);
  EXPECT_EQ(axis.command(0x0086), 0x0250) << "and not Ready to switch on";
  EXPECT_EQ(axis.command(0x0086), 0x0250);
  EXPECT_EQ(axis.step(10), 0x0250);
  EXPECT_EQ(axis.command(0x0006), 0x0231) << "the next level command counts";
}

TEST(Fault, AHeld8FhDoesNothingAfterTheResetAnd0FhEnables) {
  AxisUnderTest axis;
  axis.write("op_mode_cmd", 1);
  axis.write("test_over_current", 1);
  axis.step(3);
  axis.write("test_over_current", 0);
  EXPECT_EQ(axis.command(0x008F), 0x0250);
  EXPECT_EQ(axis.command(0x008F), 0x0250);
  EXPECT_EQ(axis.command(0x000F), 0x0637);
}

TEST(Fault, AResetNeedsAllCausesRemoved) {
  AxisUnderTest axis;
  axis.write("test_over_current", 1);
  axis.step(3);
  axis.write("test_over_temperature", 1);
  axis.step(3);
  EXPECT_EQ(axis.read("error_code"), 0x4310) << "603Fh holds the last error";
  EXPECT_EQ(axis.read("error_history_count"), 2);
  axis.write("test_over_current", 0);
  EXPECT_EQ(axis.command(0x0080), 0x0218);
  axis.command(0x0000);
  axis.write("test_over_temperature", 0);
  EXPECT_EQ(axis.command(0x0080), 0x0250);
}

TEST(Fault, ACauseThatReturnsInTheTickOfTheResetIsANewFault) {
  AxisUnderTest axis;
  axis.write("test_over_current", 1);
  axis.step(3);
  axis.write("test_over_current", 0);
  axis.controlword(0x0080);
  axis.write("test_over_current", 1);
  EXPECT_EQ(axis.step(), 0x021F);
  EXPECT_EQ(axis.step(), 0x0218);
  EXPECT_EQ(axis.read("error_history_count"), 2);
}

TEST(Fault, AnEncoderFailureDuringABrakingReactionRemovesThePower) {
  AxisUnderTest axis;
  ASSERT_NO_FATAL_FAILURE(start_moving_to_fail(axis));
  axis.write("quick_stop_deceleration", 10'000);
  axis.write("test_over_current", 1);
  axis.step(100);
  ASSERT_EQ(axis.statusword(), 0x021F);
  ASSERT_EQ(axis.read("motor_op_status"), 1);
  axis.write("test_encoder_failure", 1);
  axis.step();
  EXPECT_EQ(axis.read("motor_op_status"), 0);
  EXPECT_NE(axis.step_until_status(0x004F, 0x0008, 2), 0U);
}

// ---- DC link -----------------------------------------------------------------------------------

TEST(DcLink, LostWithoutPowerClearsBit4AndLeadsToSwitchOnDisabledWithoutAFault) {
  for (const std::uint16_t word : {std::uint16_t{0x0000}, std::uint16_t{0x0006}}) {
    AxisUnderTest axis;
    axis.command(word);
    axis.write("test_dc_link_loss", 1);
    EXPECT_EQ(axis.step(), 0x0240);
    EXPECT_EQ(axis.read("error_code"), 0);
    EXPECT_EQ(axis.read("dc_link_circuit_voltage"), 0);
    for (const std::uint16_t command : {std::uint16_t{0x0006}, std::uint16_t{0x000F}}) {
      EXPECT_EQ(axis.command(command), 0x0240) << "nothing leaves without voltage";
    }
    axis.write("test_dc_link_loss", 0);
    EXPECT_EQ(axis.step(), 0x0250);
    EXPECT_EQ(axis.read("dc_link_circuit_voltage"), 310'000);
  }
  AxisUnderTest axis;
  axis.command(0x0006);
  axis.command(0x0007);
  axis.write("test_dc_link_loss", 1);
  EXPECT_EQ(axis.step(), 0x0240);
}

TEST(DcLink, LostAgainInTheTickOfEnablingIsAFault) {
  AxisUnderTest axis;
  axis.write("op_mode_cmd", 1);
  axis.write("test_dc_link_loss", 1);
  ASSERT_EQ(axis.step(), 0x0240);
  axis.write("test_dc_link_loss", 0);
  axis.controlword(0x000F);
  axis.write("test_dc_link_loss", 1);
  EXPECT_EQ(axis.step(), 0x020F);
  EXPECT_EQ(axis.read("error_code"), 0x3220);
}

TEST(DcLink, LostInAQuickStopIsAFault) {
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 6);
  axis.enable();
  axis.command(0x0002);
  axis.write("test_dc_link_loss", 1);
  axis.step(3);
  EXPECT_EQ(axis.statusword(), 0x0208);
  EXPECT_EQ(axis.read("error_code"), 0x3220);
}

// ---- following error ---------------------------------------------------------------------------

TEST(FollowingError, ABlockedLoadCausesAFollowingErrorFault) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("test_blocked_load", 1);
  axis.write("profile_velocity", 40'000);
  axis.write("position_user_target_value", 1'000'000);
  axis.controlword(0x003F);
  std::int64_t outside_since = -1;
  for (std::int64_t tick = 0; tick < 5'000 && axis.state() == operation_enabled; ++tick) {
    axis.step();
    const bool outside = std::abs(axis.read("load_position_error_value")) > 20'480;  // 6065h
    if (outside && outside_since < 0) outside_since = tick;
    // "Lasts longer than 6066h": not after 20 ms, but after 21 ms.
    const bool expected = outside_since >= 0 && tick - outside_since > 20;
    ASSERT_EQ((axis.statusword() & Statusword::kFollowingError) != 0, expected) << "tick " << tick;
  }
  EXPECT_EQ(axis.read("error_code"), 0x8611);
  EXPECT_EQ(axis.read("error_register") & 0x20, 0x20);
  EXPECT_NE(axis.step_until_state(fault, 2'000), 0U);
  EXPECT_EQ(axis.statusword(), 0x2218) << "bit 13 is kept until the reset";
  axis.step(100);
  EXPECT_EQ(axis.statusword(), 0x2218);
  EXPECT_EQ(axis.actual(), 0);
  axis.write("test_blocked_load", 0);
  EXPECT_EQ(axis.command(0x0086), 0x0250);
  EXPECT_EQ(axis.command(0x000F), 0x0637) << "no jump: the demand is the actual position";
}

TEST(FollowingError, TheTimerIsClearedInsideTheWindow) {
  AxisUnderTest axis;
  axis.write("following_error_window", 1'000);
  axis.write("following_error_time_out", 100);
  axis.enable();
  axis.write("profile_velocity", 40'000);
  axis.write("position_user_target_value", 1'000'000);
  axis.command(0x003F);
  for (int i = 0; i < 10; ++i) {
    axis.write("test_blocked_load", 1);
    axis.step(60);  // outside the window for about 35 ms
    axis.write("test_blocked_load", 0);
    ASSERT_NE(axis.step_until(
                  [&axis] {
                    return std::abs(axis.read("load_position_error_value")) < 900;
                  },
                  500),
              0U);
    ASSERT_EQ(axis.state(), operation_enabled) << "round " << i;
  }
}

TEST(FollowingError, IsOffWithAWindowOfFFFFFFFFh) {
  AxisUnderTest axis;
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.enable();
  axis.write("test_blocked_load", 1);
  axis.write("position_user_target_value", 1'000'000);
  axis.command(0x003F);
  axis.step(5'000);
  EXPECT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.read("error_code"), 0);
}

TEST(FollowingError, AWindowOf0MeansAnyDeviation) {
  AxisUnderTest axis;
  axis.write("following_error_window", 0);
  axis.write("following_error_time_out", 0);
  axis.enable();
  axis.step(100);
  EXPECT_EQ(axis.state(), operation_enabled) << "at rest there is none";
  axis.write("test_load_torque", 1'000);
  EXPECT_NE(axis.step_until(
                [&axis] {
                  return axis.read("error_code") == 0x8611;
                },
                100),
            0U);
}

TEST(FollowingError, IsAWarningWhereTheSettingSaysSo) {
  AxisConfiguration configuration;
  configuration.settings.following_error_is_fault = false;
  AxisUnderTest axis(configuration);
  axis.enable();
  axis.write("test_blocked_load", 1);
  axis.write("profile_velocity", 40'000);
  axis.write("position_user_target_value", 60'000);
  axis.command(0x003F);
  EXPECT_NE(axis.step_until_status(Statusword::kFollowingError, Statusword::kFollowingError, 2'000),
            0U);
  EXPECT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.read("error_code"), 0);
  axis.write("test_blocked_load", 0);
  EXPECT_NE(axis.step_until_status(Statusword::kFollowingError, 0, 2'000), 0U);
  EXPECT_NE(axis.step_until_reached(5'000), 0U);
}

TEST(FollowingError, IsMonitoredOnlyWhileTheAxisIsControlled) {
  AxisUnderTest axis;
  axis.write("following_error_window", 1);
  axis.write("following_error_time_out", 0);
  axis.write("test_load_torque", 3'000);
  axis.step(1'000);
  EXPECT_EQ(axis.statusword(), 0x0250);
  EXPECT_GT(axis.velocity(), 1'000) << "driven by the load";
}

// ---- limit switches ----------------------------------------------------------------------------

class LimitSwitch : public testing::TestWithParam<int> {
 protected:
  [[nodiscard]] int sign() const { return GetParam(); }

  [[nodiscard]] const char* input() const {
    return sign() > 0 ? "test_positive_limit_input" : "test_negative_limit_input";
  }

  AxisUnderTest axis;
};

TEST_P(LimitSwitch, IsVisibleInTheDigitalInputsAndBit11) {
  axis.enable();
  axis.write(input(), 1);
  axis.step();
  EXPECT_EQ(axis.read("digital_inputs"), sign() > 0 ? 2 : 1);
  EXPECT_TRUE(axis.limit_active());
  axis.write(input(), 0);
  axis.step();
  EXPECT_EQ(axis.read("digital_inputs"), 0);
  EXPECT_FALSE(axis.limit_active());
}

TEST_P(LimitSwitch, StopsMotionTowardsItWithTheQuickStopRampWithoutAFault) {
  axis.write("quick_stop_deceleration", 400'000);
  axis.enable();
  axis.write("profile_velocity", 40'000);
  axis.write("position_user_target_value", sign() * 1'000'000);
  axis.command(0x003F);
  axis.step(300);
  axis.write(input(), 1);
  axis.step();
  EXPECT_NEAR(axis.demand_velocity() * sign(), 39'600, 1);
  axis.step(200);
  EXPECT_EQ(axis.demand_velocity(), 0);
  EXPECT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.read("error_code"), 0);
  EXPECT_FALSE(axis.reached()) << "its target was not reached";
  const std::int32_t rest = axis.demand();
  axis.write(input(), 0);
  axis.step(500);
  EXPECT_EQ(axis.demand(), rest) << "the dropped target stays dropped";
  EXPECT_FALSE(axis.reached());
  axis.command(0x000F);
  axis.write("position_user_target_value", 0);
  axis.command(0x003F);
  EXPECT_NE(axis.step_until_reached(10'000), 0U);
}

TEST_P(LimitSwitch, LetsTheAxisMoveAway) {
  axis.enable();
  axis.write(input(), 1);
  axis.write("position_user_target_value", sign() * -5'000);
  axis.command(0x003F);
  EXPECT_NE(axis.step_until_reached(5'000), 0U);
  EXPECT_EQ(axis.demand(), sign() * -5'000);
}

TEST_P(LimitSwitch, PreventsMotionTowardsIt) {
  axis.enable();
  axis.write(input(), 1);
  axis.step();
  axis.write("position_user_target_value", sign() * 5'000);
  axis.command(0x003F);
  axis.step(500);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_FALSE(axis.reached());
}

TEST_P(LimitSwitch, ASetPointTowardsItIsStillAcknowledgedWhileBit4IsHeld) {
  // The handshake must not hang (docs/explanation/decisions.md): a master waits for bit 12 before
  // it clears bit 4.
  axis.enable();
  axis.write(input(), 1);
  axis.step();
  axis.write("position_user_target_value", sign() * 5'000);
  axis.command(0x003F);
  EXPECT_TRUE(axis.acknowledged());
  axis.step(10);
  EXPECT_TRUE(axis.acknowledged());
  axis.command(0x000F);
  EXPECT_FALSE(axis.acknowledged());
}

INSTANTIATE_TEST_SUITE_P(Fault, LimitSwitch, testing::Values(1, -1), [](const auto& row) {
  return row.param > 0 ? "positive" : "negative";
});

TEST(TestBench, HomeInputShowsInTheDigitalInputs) {
  AxisUnderTest axis;
  axis.write("test_home_input", 1);
  axis.step();
  EXPECT_EQ(axis.read("digital_inputs"), 4);
  EXPECT_EQ(axis.statusword(), 0x0250);
}

}  // namespace
}  // namespace vdrive
