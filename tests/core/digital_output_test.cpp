// SPDX-License-Identifier: Apache-2.0
// Digital outputs 60FEh.
#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/dictionary/standard_names.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;

TEST(DigitalOutputs, AreOffAndMaskedByDefaultAndReadBackAsWritten) {
  AxisUnderTest axis;
  EXPECT_EQ(axis.read("digital_outputs"), 0);
  EXPECT_EQ(axis.read("digital_outputs_mask"), 0);
  for (const std::int64_t value : {0x0001'0000LL, 0xFFFF'0000LL, 0x0000'0001LL, 0xFFFF'FFFFLL}) {
    axis.write("digital_outputs", value);
    axis.write("digital_outputs_mask", value);
    axis.step();
    EXPECT_EQ(axis.read("digital_outputs"), value);
    EXPECT_EQ(axis.read("digital_outputs_mask"), value);
  }
  EXPECT_EQ(axis.try_write("digital_outputs", 0x1'0000'0000), AbortCode{0x06090031});
  EXPECT_EQ(axis.try_write("digital_outputs_mask", -1), AbortCode{0x06090032});
}

TEST(DigitalOutputs, HaveTheSubIndices1And2AndTheNamesOfTheStandard) {
  AxisUnderTest axis;
  EXPECT_EQ(axis.axis().write({0x60FE, 0}, 0), AbortCode{0x06090011});
  EXPECT_EQ(axis.axis().write({0x60FE, 3}, 0), AbortCode{0x06090011});
  EXPECT_EQ(find_named("physical_outputs"), find_object(ObjectAddress{0x60FE, 1}));
  EXPECT_EQ(find_named("bit_mask"), find_object(ObjectAddress{0x60FE, 2}));
}

TEST(DigitalOutputs, ChangeNothingOfTheAxis) {
  AxisUnderTest axis;
  AxisUnderTest other;
  for (AxisUnderTest* const each : {&axis, &other}) {
    each->enable();
    each->write("position_user_target_value", 10'000);
    each->command(0x001F);
  }
  axis.write("digital_outputs_mask", 0xFFFF'FFFF);
  axis.write("digital_outputs", 0xFFFF'FFFF);
  for (int tick = 0; tick < 500; ++tick) {
    axis.step();
    other.step();
    ASSERT_EQ(axis.statusword(), other.statusword());
    ASSERT_EQ(axis.actual(), other.actual());
    ASSERT_EQ(axis.status().torque_actual_value, other.status().torque_actual_value);
  }
}

TEST(DigitalOutputs, StayInAFaultAndAreOffAfterAPowerCycleWithAStoredMask) {
  AxisBank bank(std::vector<AxisConfiguration>(1), std::chrono::microseconds{1'000});
  ASSERT_EQ(bank.set_stored(0, {0x60FE, 2}, 0x0003'0000), AbortCode::none);
  EXPECT_EQ(bank.set_stored(0, {0x60FE, 1}, 0x0001'0000), AbortCode::cannot_store_or_transfer);
  bank.write(0, {0x60FE, 1}, 0x0001'0000);
  bank.write(0, {0x5E02, 0}, 1);
  bank.step();
  bank.step();
  ASSERT_EQ(bank.read(0, {0x603F, 0}).value, 0x2310);
  EXPECT_EQ(bank.read(0, {0x60FE, 1}).value, 0x0001'0000);
  bank.write(0, {0x5E02, 0}, 0);
  bank.power_cycle(0);
  EXPECT_EQ(bank.read(0, {0x60FE, 1}).value, 0);
  EXPECT_EQ(bank.read(0, {0x60FE, 2}).value, 0x0003'0000);
}

}  // namespace
}  // namespace vdrive
