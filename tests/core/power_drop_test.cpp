// SPDX-License-Identifier: Apache-2.0
// 5E0Bh: the drive drops from Operation enabled to Switched on without a command or a fault.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

constexpr ObjectAddress kPowerDrop{0x5E0B, 0};

/// On a long move at 40000 UU/s, controlword 001Fh.
void run_enabled(AxisUnderTest& axis) {
  axis.write("profile_velocity", 40'000);
  axis.enable();
  axis.write("position_user_target_value", 10'000'000);
  axis.command(0x001F);
  axis.step(300);
  ASSERT_EQ(axis.demand_velocity(), 40'000);
}

TEST(PowerDrop, LeadsToSwitchedOnWithoutAFaultAndTheAxisCoasts) {
  AxisUnderTest axis;
  run_enabled(axis);
  axis.write("test_power_drop", 1);
  EXPECT_EQ(axis.step() & 0x006F, 0x0023) << "Switched on";
  EXPECT_EQ(axis.status().motor_op_status, 0);
  EXPECT_EQ(axis.read("torque_actual_value"), 0);
  EXPECT_GT(axis.velocity(), 30'000) << "no stop: friction alone brakes it";
  EXPECT_EQ(axis.demand_velocity(), 0);
  EXPECT_EQ(axis.read("error_code"), 0);
  EXPECT_EQ(axis.read("error_register"), 0);
  EXPECT_EQ(axis.status().fault_count, 0U);
  EXPECT_EQ(axis.read("error_history_count"), 0);
}

// 605Ch applies to the commanded transition 5: a ramp would need the power that is gone.
TEST(PowerDrop, TakesNoRampWhatever605ChSays) {
  for (const std::int64_t option : {0, 1}) {
    AxisUnderTest axis;
    axis.write("disable_operation_option_code", option);
    run_enabled(axis);
    axis.write("test_power_drop", 1);
    axis.step();
    EXPECT_EQ(axis.state(), switched_on) << "605Ch = " << option;
  }
}

TEST(PowerDrop, EndsARampThatIsUnderWay) {
  AxisUnderTest axis;
  axis.write("shutdown_option_code", 1);
  run_enabled(axis);
  axis.command(0x0006);
  ASSERT_EQ(axis.state(), operation_enabled) << "605Bh: transition 8 waits for the ramp";
  axis.write("test_power_drop", 1);
  axis.step();
  EXPECT_EQ(axis.state(), switched_on);
  axis.step(2'000);
  EXPECT_EQ(axis.state(), switched_on) << "Shutdown was taken back with the power";
}

TEST(PowerDrop, WaitsForANewControlword) {
  AxisUnderTest axis;
  run_enabled(axis);
  axis.write("test_power_drop", 1);
  axis.step(2'000);
  EXPECT_EQ(axis.state(), switched_on) << "001Fh still stands";
  EXPECT_EQ(axis.read("ds402_controlword"), 0x001F);
  axis.write("test_power_drop", 0);
  axis.step(100);
  EXPECT_EQ(axis.state(), switched_on) << "neither does the input enable it";
  const std::int32_t stopped_at = axis.actual();
  axis.command(0x000F);
  EXPECT_EQ(axis.state(), operation_enabled);
  axis.step(100);
  EXPECT_EQ(axis.demand(), stopped_at) << "the earlier set-point is forgotten";
}

TEST(PowerDrop, ActsWithItsEdgeOnly) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("test_power_drop", 0);
  axis.step();
  EXPECT_EQ(axis.state(), operation_enabled);
  axis.write("test_power_drop", 1);
  axis.step();
  ASSERT_EQ(axis.state(), switched_on);
  axis.enable();
  axis.write("test_power_drop", 1);
  axis.step(100);
  EXPECT_EQ(axis.state(), operation_enabled) << "1 is no state in which the axis stays";
  axis.write("test_power_drop", 0);
  axis.write("test_power_drop", 1);
  axis.step();
  EXPECT_EQ(axis.state(), switched_on);
}

TEST(PowerDrop, LeavesAxesAloneThatAreNotEnabled) {
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 6);
  const auto expect_state_kept = [&axis](PowerState state) {
    ASSERT_EQ(axis.state(), state);
    axis.write("test_power_drop", 1);
    axis.step();
    EXPECT_EQ(axis.state(), state);
    axis.write("test_power_drop", 0);
  };
  axis.step();
  expect_state_kept(switch_on_disabled);
  axis.command(0x0006);
  expect_state_kept(ready_to_switch_on);
  axis.command(0x0007);
  expect_state_kept(switched_on);
  axis.enable();
  axis.command(0x0002);
  expect_state_kept(quick_stop_active);
  axis.write("test_over_current", 1);
  axis.step(100);
  expect_state_kept(fault);
}

TEST(PowerDrop, OutlastsAPowerCycleAndIsNoEdgeThere) {
  AxisConfiguration configuration;
  configuration.parameters = {{kPowerDrop, 1}};
  AxisUnderTest axis(configuration);
  axis.axis().power_cycle();
  axis.step();
  EXPECT_EQ(axis.read("test_power_drop"), 1);
  axis.enable();
  axis.step(100);
  EXPECT_EQ(axis.state(), operation_enabled);
}

TEST(PowerDrop, RefusesOtherValuesAndIsNotStored) {
  AxisUnderTest axis;
  axis.enable();
  EXPECT_EQ(axis.try_write("test_power_drop", 2), AbortCode::value_too_high);
  EXPECT_EQ(axis.try_write("test_power_drop", -1), AbortCode::value_too_low);
  axis.step(100);
  EXPECT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.axis().set_stored(kPowerDrop, 1), AbortCode::cannot_store_or_transfer);
}

}  // namespace
}  // namespace vdrive
