// SPDX-License-Identifier: Apache-2.0
// 5E0Ah: the test bench cuts the connection of an axis to its master.
#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

constexpr ObjectAddress kConnectionLoss{0x5E0A, 0};

/// A bank of one axis on a long move at 40000 UU/s.
AxisBank running_bank(std::int64_t abort_connection_option_code) {
  AxisBank bank(std::vector<AxisConfiguration>(1), std::chrono::milliseconds{1});
  const auto put = [&bank](std::string_view name, std::int64_t value) {
    EXPECT_EQ(bank.write(0, AxisUnderTest::address_of(name), value), AbortCode::none) << name;
  };
  put("abort_connection_option_code", abort_connection_option_code);
  put("profile_velocity", 40'000);
  put("op_mode_cmd", 1);
  put("ds402_controlword", 0x0F);
  bank.step();
  put("position_user_target_value", 10'000'000);
  put("ds402_controlword", 0x1F);
  for (int tick = 0; tick < 300; ++tick) bank.step();
  EXPECT_EQ(bank.status(0).velocity_demand_value, 40'000);
  return bank;
}

TEST(ConnectionLoss, DoesWhatASilentMasterDoesBitForBit) {
  for (const std::int64_t option : {0, 1, 2, 3}) {
    SCOPED_TRACE("6007h = " + std::to_string(option));
    AxisBank silent = running_bank(option);
    AxisBank disturbed = running_bank(option);
    silent.report_connection_loss(0);
    ASSERT_EQ(disturbed.write(0, kConnectionLoss, 1), AbortCode::none);
    EXPECT_EQ(disturbed.power_state(0), silent.power_state(0)) << "at once";
    for (int tick = 0; tick < 1'500; ++tick) {
      silent.step();
      disturbed.step();
      ASSERT_EQ(disturbed.status_hash(), silent.status_hash()) << tick;
    }
    EXPECT_EQ(disturbed.status(0).error_code, option == 1 ? 0x8130 : 0);
    EXPECT_EQ(disturbed.power_state(0) == operation_enabled, option == 0);
  }
}

TEST(ConnectionLoss, ActsWithItsEdgeOnly) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("test_connection_loss", 0);
  EXPECT_EQ(axis.step(), 0x0637);
  axis.write("test_connection_loss", 1);
  axis.step(500);
  EXPECT_EQ(axis.state(), fault);
  axis.command(0x0080);
  axis.enable();
  axis.write("test_connection_loss", 1);
  axis.step(500);
  EXPECT_EQ(axis.state(), operation_enabled) << "1 is no state in which the axis stays";
  EXPECT_EQ(axis.status().fault_count, 1U);
  axis.write("test_connection_loss", 0);
  axis.step(500);
  EXPECT_EQ(axis.state(), operation_enabled);
  axis.write("test_connection_loss", 1);
  axis.step(500);
  EXPECT_EQ(axis.read("error_code"), 0x8130);
  EXPECT_EQ(axis.status().fault_count, 2U);
}

TEST(ConnectionLoss, ActsAlsoWhenItIsTakenBackInTheSameTick) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("test_connection_loss", 1);
  axis.write("test_connection_loss", 0);
  axis.step();
  EXPECT_EQ(axis.read("error_code"), 0x8130);
}

TEST(ConnectionLoss, HasAnEffectOnlyWhileTheAxisIsControlled) {
  for (const std::int64_t option : {1, 2, 3}) {
    AxisUnderTest axis;
    axis.write("abort_connection_option_code", option);
    for (const auto& [word, shown] :
         {std::pair{0x0000, 0x0250}, std::pair{0x0006, 0x0231}, std::pair{0x0007, 0x0233}}) {
      axis.command(static_cast<std::uint16_t>(word));
      axis.write("test_connection_loss", 1);
      EXPECT_EQ(axis.step(), shown) << option;
      axis.write("test_connection_loss", 0);
    }
  }
}

TEST(ConnectionLoss, IsAFaultAlsoInQuickStopActive) {
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 6);
  axis.enable();
  axis.command(0x0002);
  ASSERT_EQ(axis.state(), quick_stop_active);
  axis.write("test_connection_loss", 1);
  axis.step(100);
  EXPECT_EQ(axis.state(), fault);
  EXPECT_EQ(axis.read("error_code"), 0x8130);
}

TEST(ConnectionLoss, OutlastsAPowerCycleAndIsNoEdgeThere) {
  AxisConfiguration configuration;
  configuration.parameters = {{kConnectionLoss, 1}};
  AxisUnderTest axis(configuration);
  EXPECT_EQ(axis.read("test_connection_loss"), 1);
  axis.axis().power_cycle();
  axis.step();
  EXPECT_EQ(axis.read("test_connection_loss"), 1);
  axis.enable();
  axis.step(100);
  EXPECT_EQ(axis.state(), operation_enabled);
}

TEST(ConnectionLoss, RefusesOtherValues) {
  AxisUnderTest axis;
  axis.enable();
  EXPECT_EQ(axis.try_write("test_connection_loss", 2), AbortCode::value_too_high);
  EXPECT_EQ(axis.try_write("test_connection_loss", -1), AbortCode::value_too_low);
  axis.step(100);
  EXPECT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.axis().set_stored(kConnectionLoss, 1), AbortCode::cannot_store_or_transfer);
}

TEST(ConnectionLoss, IsPartOfASnapshot) {
  AxisBank bank = running_bank(3);
  const AxisBank::Snapshot before = bank.snapshot();
  bank.write(0, kConnectionLoss, 1);
  const AxisBank::Snapshot lost = bank.snapshot();
  std::vector<std::uint64_t> hashes;
  for (int tick = 0; tick < 500; ++tick) {
    bank.step();
    hashes.push_back(bank.status_hash());
  }
  AxisBank other = running_bank(3);
  other.restore(other.snapshot_from(lost.bytes()));
  EXPECT_EQ(other.write(0, kConnectionLoss, 1), AbortCode::none) << "no edge: it was 1 there";
  for (const std::uint64_t hash : hashes) {
    other.step();
    ASSERT_EQ(other.status_hash(), hash);
  }
  other.restore(before);
  EXPECT_EQ(other.read(0, kConnectionLoss).value, 0);
  EXPECT_EQ(other.power_state(0), operation_enabled);
  other.write(0, kConnectionLoss, 1);
  EXPECT_EQ(other.power_state(0), quick_stop_active);
}

}  // namespace
}  // namespace vdrive
