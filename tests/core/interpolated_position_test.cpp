// SPDX-License-Identifier: Apache-2.0
// Interpolated position mode (6060h = 7): 60C0h, 60C1h, 60C4h, bits 4 and 12.
#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace vdrive {
namespace {

using std::chrono::microseconds;
using test::AxisUnderTest;
using enum PowerState;

/// Interpolated position, Operation enabled, at rest; one record every 10 ms.
/// @param size of the buffer; 1 = none
void enable_interpolated_position(AxisUnderTest& axis, std::int64_t size, std::uint16_t word) {
  axis.write("interpolation_time_period", 10);
  axis.write("interpolation_buffer_size", size);
  axis.write("interpolation_buffer_clear", 1);
  axis.write("op_mode_cmd", 7);
  axis.command(word);
}

void add_record(AxisUnderTest& axis, std::int32_t record) {
  axis.write("interpolation_data_record", record);
}

// ---- bit 4 --------------------------------------------------------------------------------------

TEST(InterpolatedPosition, IsInactiveUntilBit4) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 1, 0x000F);
  EXPECT_EQ(axis.statusword(), 0x0637);
  add_record(axis, 100);
  axis.step(50);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_EQ(axis.statusword(), 0x0237) << "bit 10: a record waits";
  axis.command(0x001F);
  EXPECT_EQ(axis.demand(), 10);
  EXPECT_EQ(axis.statusword(), 0x1237);
}

TEST(InterpolatedPosition, ARecordIsReachedAfter60C2h) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    enable_interpolated_position(axis, 1, 0x001F);
    EXPECT_EQ(axis.statusword(), 0x1637) << "active, and no record to go to";
    add_record(axis, sign * 1'000);
    for (int tick = 1; tick <= 10; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand(), sign * 100 * tick);
      ASSERT_EQ(axis.demand_velocity(), sign * 100'000);
      ASSERT_EQ(axis.statusword(), 0x1237);
    }
    axis.step(200);
    EXPECT_EQ(axis.demand(), sign * 1'000);
    EXPECT_EQ(axis.statusword(), 0x1637);
    EXPECT_EQ(axis.status().ignored_set_points, 0U);
  }
}

TEST(InterpolatedPosition, BitFourIsALevel) {
  AxisUnderTest axis;
  axis.write("op_mode_cmd", 7);
  axis.command(0x001F);  // bit 4 was set before the mode could be active
  EXPECT_TRUE(axis.interpolates());
  EXPECT_EQ(axis.status().ignored_set_points, 0U);
}

TEST(InterpolatedPosition, WithoutBit4TheAxisBrakesWith6084hAndTheWayIsForgotten) {
  AxisUnderTest axis;
  axis.write("profile_dec", 1'000'000);
  enable_interpolated_position(axis, 4, 0x001F);
  for (const std::int32_t record : {1'000, 5'400, 5'300}) add_record(axis, record);
  axis.step(5);
  ASSERT_EQ(axis.demand(), 500);
  axis.controlword(0x000F);
  for (int tick = 1; tick <= 99; ++tick) {
    axis.step();
    ASSERT_NEAR(axis.demand_velocity(), 100'000 - 1'000 * tick, 1);
    ASSERT_EQ(axis.statusword(), 0x0237);
  }
  axis.step(300);
  EXPECT_EQ(axis.demand(), 5'500) << "100000²/(2·1000000) further";
  EXPECT_EQ(axis.read("interpolation_buffer_position"), 2) << "the others wait";
  axis.controlword(0x001F);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 5'500 - 10 * tick) << "from here to the next record";
  }
}

TEST(InterpolatedPosition, ARecordMovesTheAxisOnce) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 1, 0x001F);
  add_record(axis, 100);
  axis.step(5);
  axis.command(0x000F);
  axis.step(100);
  const std::int32_t rest = axis.demand();
  axis.command(0x001F);
  axis.step(100);
  EXPECT_EQ(axis.demand(), rest) << "the interrupted way is not taken up again";
  add_record(axis, 100);
  axis.step(10);
  EXPECT_EQ(axis.demand(), 100);
}

// ---- without a buffer ---------------------------------------------------------------------------

TEST(InterpolatedPosition, WithoutABufferARecordBeginsItsWayAtOnce) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 1, 0x001F);
  add_record(axis, 1'000);
  axis.step(4);
  ASSERT_EQ(axis.demand(), 400);
  add_record(axis, 0);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 400 - 40 * tick);
  }
}

TEST(InterpolatedPosition, WithoutABufferTheSameRecordAgainDoesNotDelayTheWay) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 1, 0x001F);
  for (int tick = 1; tick <= 10; ++tick) {
    add_record(axis, 1'000);
    axis.step();
    ASSERT_EQ(axis.demand(), 100 * tick);
  }
}

TEST(InterpolatedPosition, WithoutABufferTheLastRecordOfATickCounts) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 1, 0x001F);
  add_record(axis, 5'000);
  add_record(axis, 100);
  axis.step(10);
  EXPECT_EQ(axis.demand(), 100);
  EXPECT_EQ(axis.status().ignored_set_points, 0U);
}

TEST(InterpolatedPosition, WithoutABufferNothingHasToBeOpened) {
  AxisUnderTest axis;
  axis.write("op_mode_cmd", 7);
  EXPECT_EQ(axis.read("interpolation_buffer_size"), 1);
  EXPECT_EQ(axis.read("interpolation_buffer_clear"), 0);
  axis.command(0x001F);
  add_record(axis, 100);
  axis.step();
  EXPECT_EQ(axis.demand(), 100) << "60C2h:01 = 0: in its tick";
}

// ---- with a buffer ------------------------------------------------------------------------------

TEST(InterpolatedPosition, RecordsOfTheBufferFollowEachOtherWithoutAGap) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 4, 0x000F);
  for (int record = 1; record <= 4; ++record) {
    add_record(axis, 100 * record);
    EXPECT_EQ(axis.read("interpolation_buffer_position"), record);
  }
  axis.controlword(0x001F);
  for (int tick = 1; tick <= 40; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 10 * tick);
    ASSERT_EQ(axis.demand_velocity(), 10'000);
    ASSERT_EQ(axis.read("interpolation_buffer_position"), 3 - (tick - 1) / 10);
  }
  axis.step(100);
  EXPECT_EQ(axis.demand(), 400);
  EXPECT_EQ(axis.statusword(), 0x1637);
}

TEST(InterpolatedPosition, TheBufferTakesRecordsRoundItsEnd) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 3, 0x001F);
  add_record(axis, 100);
  add_record(axis, 200);
  for (int record = 3; record <= 60; ++record) {
    add_record(axis, 100 * record);
    for (int tick = 1; tick <= 10; ++tick) {
      axis.step();
      ASSERT_EQ(axis.demand(), 100 * (record - 3) + 10 * tick);
    }
  }
  EXPECT_EQ(axis.status().ignored_set_points, 0U);
}

TEST(InterpolatedPosition, EqualRecordsOfTheBufferTakeTheirTime) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 4, 0x000F);
  for (const std::int32_t record : {100, 100, 200}) add_record(axis, record);
  axis.command(0x001F);
  axis.step(9);
  EXPECT_EQ(axis.demand(), 100);
  axis.step(10);
  EXPECT_EQ(axis.demand(), 100);
  axis.step(10);
  EXPECT_EQ(axis.demand(), 200);
}

TEST(InterpolatedPosition, ARecordForAFullBufferIsIgnoredAndCounted) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 2, 0x000F);
  for (const std::int32_t record : {100, 200, 300}) add_record(axis, record);
  EXPECT_EQ(axis.read("interpolation_buffer_position"), 2);
  axis.command(0x001F);
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
  axis.step(100);
  EXPECT_EQ(axis.demand(), 200);
}

TEST(InterpolatedPosition, ARecordForAClosedBufferIsIgnoredAndCounted) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 4, 0x001F);
  axis.write("interpolation_buffer_clear", 0);
  add_record(axis, 100);
  axis.step(50);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
  axis.write("interpolation_buffer_clear", 1);
  add_record(axis, 100);
  axis.step(10);
  EXPECT_EQ(axis.demand(), 100);
}

TEST(InterpolatedPosition, TheBufferIsEmptiedByItsClearAndByAnotherSize) {
  for (const bool by_size : {true, false}) {
    AxisUnderTest axis;
    enable_interpolated_position(axis, 4, 0x000F);
    add_record(axis, 100);
    add_record(axis, 200);
    axis.write("interpolation_buffer_clear", 1);
    axis.write("interpolation_buffer_size", 4);
    EXPECT_EQ(axis.read("interpolation_buffer_position"), 2) << "nothing has changed";
    axis.write(by_size ? "interpolation_buffer_size" : "interpolation_buffer_clear",
               by_size ? 8 : 0);
    EXPECT_EQ(axis.read("interpolation_buffer_position"), 0);
    axis.command(0x001F);
    axis.step(50);
    EXPECT_EQ(axis.demand(), 0);
  }
}

TEST(InterpolatedPosition, TheWayOfTheLastRecordGoesOnWhenTheBufferIsEmptied) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 4, 0x001F);
  add_record(axis, 100);
  add_record(axis, 200);
  axis.step(5);
  axis.write("interpolation_buffer_clear", 0);
  axis.step(50);
  EXPECT_EQ(axis.demand(), 100);
}

TEST(InterpolatedPosition, HoldsSixteenRecords) {
  AxisUnderTest axis;
  EXPECT_EQ(axis.read("interpolation_buffer_maximum_size"), 16);
  enable_interpolated_position(axis, 16, 0x000F);
  for (int record = 1; record <= 16; ++record) add_record(axis, 10 * record);
  EXPECT_EQ(axis.read("interpolation_buffer_position"), 16);
  axis.command(0x001F);
  axis.step(159);
  EXPECT_EQ(axis.demand(), 160);
  EXPECT_EQ(axis.status().ignored_set_points, 0U);
}

// ---- ends of an interpolation ------------------------------------------------------------------

TEST(InterpolatedPosition, HaltBrakesBy605DhAndBit10IsStandstill) {
  AxisUnderTest axis;
  axis.write("profile_dec", 1'000'000);
  enable_interpolated_position(axis, 4, 0x001F);
  add_record(axis, 1'000);
  axis.step(5);
  axis.controlword(0x011F);
  for (int tick = 1; tick <= 99; ++tick) {
    axis.step();
    ASSERT_NEAR(axis.demand_velocity(), 100'000 - 1'000 * tick, 1);
    ASSERT_EQ(axis.statusword(), 0x0237);
  }
  axis.step(300);
  EXPECT_EQ(axis.statusword(), 0x0637);
  axis.command(0x001F);
  axis.step(50);
  EXPECT_EQ(axis.demand(), 5'500) << "the interrupted way is not taken up again";
  add_record(axis, 5'600);
  axis.step();
  EXPECT_EQ(axis.demand(), 5'510);
}

TEST(InterpolatedPosition, AQuickStopEmptiesTheBuffer) {
  AxisUnderTest axis;
  axis.write("quick_stop_deceleration", 1'000'000);
  axis.write("quick_stop_option_code", 6);
  enable_interpolated_position(axis, 4, 0x001F);
  add_record(axis, 1'000);
  add_record(axis, 2'000);
  axis.step(5);
  axis.command(0x0012);
  EXPECT_NEAR(axis.demand_velocity(), 99'000, 1);
  EXPECT_EQ(axis.read("interpolation_buffer_position"), 0);
  axis.step(400);
  EXPECT_EQ(axis.statusword(), 0x0617);
  axis.command(0x001F);
  axis.step(50);
  EXPECT_EQ(axis.demand(), 5'500);
}

TEST(InterpolatedPosition, AFaultEmptiesTheBufferAndBrakesBy605Eh) {
  AxisUnderTest axis;
  axis.write("quick_stop_deceleration", 1'000'000);
  enable_interpolated_position(axis, 4, 0x001F);
  add_record(axis, 1'000);
  add_record(axis, 2'000);
  axis.step(5);
  axis.write("test_over_temperature", 1);
  axis.step();
  EXPECT_NEAR(axis.demand_velocity(), 99'000, 1);
  EXPECT_EQ(axis.read("interpolation_buffer_position"), 0);
  axis.step(500);
  EXPECT_EQ(axis.statusword(), 0x0218);
}

TEST(InterpolatedPosition, ALimitSwitchStopsWith6085hAndDropsTheRecords) {
  AxisUnderTest axis;
  axis.write("quick_stop_deceleration", 1'000'000);
  enable_interpolated_position(axis, 4, 0x001F);
  add_record(axis, 1'000);
  add_record(axis, 2'000);
  axis.step(5);
  axis.write("test_positive_limit_input", 1);
  axis.step();
  EXPECT_NEAR(axis.demand_velocity(), 99'000, 1);
  EXPECT_EQ(axis.read("interpolation_buffer_position"), 0);
  EXPECT_FALSE(axis.interpolates());
  axis.step(400);
  EXPECT_EQ(axis.demand(), 5'500);
  EXPECT_FALSE(axis.interpolates()) << "until the next record";
  add_record(axis, 5'400);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 5'500 - 10 * tick) << "away from the switch";
    ASSERT_TRUE(axis.interpolates());
  }
}

TEST(InterpolatedPosition, AModeChangeBrakesAndForgetsTheRecords) {
  for (const std::int64_t mode : {0, 1, 2, 3, 4, 6, 8, 9, 10}) {
    SCOPED_TRACE(mode);
    AxisUnderTest axis;
    axis.write("profile_dec", 1'000'000);
    enable_interpolated_position(axis, 4, 0x001F);
    add_record(axis, 1'000);
    add_record(axis, 2'000);
    axis.step(5);
    axis.write("op_mode_cmd", mode);
    axis.step();
    EXPECT_NEAR(axis.demand_velocity(), 99'000, 1);
    axis.step(400);
    EXPECT_EQ(axis.read("op_mode_actual"), mode);
    EXPECT_EQ(axis.read("interpolation_buffer_position"), 0);
  }
}

TEST(InterpolatedPosition, ARecordOutsideOfOperationEnabledIsOnlyARegister) {
  AxisUnderTest axis;
  axis.write("interpolation_buffer_size", 4);
  axis.write("interpolation_buffer_clear", 1);
  axis.write("op_mode_cmd", 7);
  add_record(axis, 100);
  EXPECT_EQ(axis.read("interpolation_buffer_position"), 0);
  EXPECT_EQ(axis.read("interpolation_data_record"), 100);
  axis.command(0x001F);
  axis.step(50);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_EQ(axis.status().ignored_set_points, 0U);
}

// ---- limits -------------------------------------------------------------------------------------

TEST(InterpolatedPosition, StaysWithin607FhAnd607Dh) {
  AxisUnderTest axis;
  axis.write("app_speed_limit", 50'000);
  axis.write("app_position_limit_switch", 1);
  axis.write("user_position_lower_limit", -200);
  axis.write("user_position_upper_limit", 200);
  enable_interpolated_position(axis, 1, 0x001F);
  add_record(axis, 1'000);
  for (int tick = 1; tick <= 10; ++tick) {
    axis.step();
    ASSERT_EQ(axis.demand(), 20 * tick) << "the way leads to the limit";
  }
  EXPECT_TRUE(axis.limit_active());
  EXPECT_TRUE(axis.interpolates());
  add_record(axis, -2'000);
  axis.step();
  EXPECT_EQ(axis.demand(), 160) << "40 a tick are within 607Fh";
}

TEST(InterpolatedPosition, ABlockedAxisHasAFollowingError) {
  AxisUnderTest axis;
  axis.write("following_error_window", 100);
  axis.write("following_error_time_out", 0);
  axis.write("test_blocked_load", 1);
  enable_interpolated_position(axis, 1, 0x001F);
  // 100 UU per tick: outside 6065h in the second tick, for longer than 6066h = 0 in the third.
  add_record(axis, 1'000);
  axis.step(2);
  EXPECT_EQ(axis.statusword(), 0x1237);
  axis.step();
  EXPECT_EQ(axis.statusword(), 0x221F) << "the fault reaction, bit 13";
  EXPECT_EQ(axis.read("error_code"), 0x8611);
  // 605Eh = 2: braking from 100000 UU/s with 6085h = 2048000 UU/s² takes 49 ticks.
  axis.step(48);
  EXPECT_EQ(axis.statusword(), 0x221F);
  axis.step(3);
  EXPECT_EQ(axis.statusword(), 0x2218);
}

// ---- objects ------------------------------------------------------------------------------------

TEST(InterpolatedPosition, RefusesWhatItDoesNotHave) {
  AxisUnderTest axis;
  for (const std::int64_t mode : {-2, -1, 1, 32'767}) {
    EXPECT_EQ(axis.try_write("interpolation_sub_mode_select", mode), AbortCode{0x06090030}) << mode;
  }
  EXPECT_EQ(axis.try_write("interpolation_sub_mode_select", 0), AbortCode::none);
  EXPECT_EQ(axis.try_write("interpolation_buffer_organization", 1), AbortCode{0x06090030});
  EXPECT_EQ(axis.try_write("interpolation_buffer_record_size", 8), AbortCode{0x06090030});
  EXPECT_EQ(axis.try_write("interpolation_buffer_size", 0), AbortCode{0x06090032});
  EXPECT_EQ(axis.try_write("interpolation_buffer_size", 17), AbortCode{0x06090031});
  EXPECT_EQ(axis.try_write("interpolation_buffer_clear", 2), AbortCode{0x06090031});
  EXPECT_EQ(axis.try_write("interpolation_buffer_maximum_size", 16), AbortCode{0x06010002});
  EXPECT_EQ(axis.try_write("interpolation_buffer_position", 0), AbortCode{0x06010002});
  EXPECT_EQ(axis.axis().read({0x60C1, 2}).code, AbortCode::subindex_does_not_exist);
  EXPECT_EQ(axis.axis().read({0x60C4, 7}).code, AbortCode::subindex_does_not_exist);
}

TEST(InterpolatedPosition, IsEmptyAfterAPowerCycle) {
  AxisUnderTest axis;
  enable_interpolated_position(axis, 4, 0x000F);
  add_record(axis, 100);
  axis.axis().power_cycle();
  EXPECT_EQ(axis.read("interpolation_buffer_position"), 0);
  EXPECT_EQ(axis.read("interpolation_buffer_size"), 1);
}

TEST(InterpolatedPosition, ContinuesFromASnapshotInTheMiddle) {
  const std::vector<AxisConfiguration> axes(1);
  AxisBank bank(axes, microseconds{1'000});
  const auto put = [&bank](std::string_view name, std::int64_t value) {
    ASSERT_EQ(bank.write(0, AxisUnderTest::address_of(name), value), AbortCode::none) << name;
  };
  put("interpolation_time_period", 10);
  put("interpolation_buffer_size", 3);
  put("interpolation_buffer_clear", 1);
  put("op_mode_cmd", 7);
  put("ds402_controlword", 0x1F);
  bank.step();
  for (const std::int64_t record : {1'000, 1'500, 2'500}) put("interpolation_data_record", record);
  for (int tick = 0; tick < 14; ++tick) bank.step();
  const AxisBank::Snapshot middle = bank.snapshot();
  const auto rest_of_the_records = [](AxisBank& from) {
    std::vector<std::uint64_t> hashes;
    for (int tick = 15; tick <= 40; ++tick) {
      from.step();
      const int demand = tick <= 20 ? 500 + 50 * tick : 100 * tick - 500;
      EXPECT_EQ(from.status(0).position_demand_value, std::min(demand, 2'500)) << tick;
      hashes.push_back(from.status_hash());
    }
    return hashes;
  };
  const std::vector<std::uint64_t> hashes = rest_of_the_records(bank);
  bank.restore(middle);
  EXPECT_EQ(rest_of_the_records(bank), hashes);
  AxisBank other(axes, microseconds{1'000});
  other.restore(other.snapshot_from(middle.bytes()));
  EXPECT_EQ(rest_of_the_records(other), hashes);
}

}  // namespace
}  // namespace vdrive
