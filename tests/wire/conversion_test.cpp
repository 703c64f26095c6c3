// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/conversion.hpp"

#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace vdrive::wire {
namespace {

using namespace vdrive::literals;

/// Member n has the value n + 1, so all values differ.
AxisStatus status_with_distinct_values() {
  AxisStatus status;
  std::int64_t value = 0;
  for (const StatusMember& member : status_members()) member.set(status, ++value);
  return status;
}

/// Members that are not transmitted must be 0 after the conversion.
void expect_same(const AxisStatus& received, const AxisStatus& sent) {
  for (const StatusMember& member : status_members()) {
    EXPECT_EQ(member.value(received), member.is_published ? member.value(sent) : 0) << member.name;
  }
}

TEST(StatusConversion, KeepsEveryValue) {
  const AxisStatus status = status_with_distinct_values();
  msg::AxisStatus message;
  to_message(status, {.bench = 7, .axis = 3}, 42, {.session = 9, .epoch = 8, .last_sequence = 6},
             message);
  expect_same(from_message(message), status);
  EXPECT_EQ(message.bench, 7U);
  EXPECT_EQ(message.axis, 3U);
  EXPECT_EQ(message.tick, 42U);
  EXPECT_EQ(message.owner_session, 9U);
  EXPECT_EQ(message.owner_epoch, 8U);
  EXPECT_EQ(message.last_sequence, 6U);
}

TEST(StatusConversion, KeepsTheEndsOfEveryRange) {
  AxisStatus status;
  status.position_demand_value = std::numeric_limits<std::int32_t>::min();
  status.load_position_actual_value = std::numeric_limits<std::int32_t>::max();
  status.torque_demand = std::numeric_limits<std::int16_t>::min();
  status.ds402_statusword = std::numeric_limits<std::uint16_t>::max();
  status.op_mode_actual = std::numeric_limits<std::int8_t>::min();
  msg::AxisStatus message;
  to_message(status, {}, 0, {}, message);
  expect_same(from_message(message), status);
}

TEST(StatusConversion, CarriesEveryMonitoredObjectOfTheManual) {
  msg::AxisStatus message;
  const AxisStatus status = status_with_distinct_values();
  to_message(status, {}, 0, {}, message);
  EXPECT_EQ(message.ds402_statusword, status.ds402_statusword);
  EXPECT_EQ(message.current_error_value, status.current_error_value);
  const AxisStatus received = from_message(message);
  for (ObjectRow row = 0; row < kObjectTable.size(); ++row) {
    const auto& object = describe(row);
    if (object.origin == Origin::manual && object.access == Access::read_only) {
      EXPECT_NE(value_of(received, row).value_or(0), 0)
          << object.variable_name
          << " needs a row of kStatusFields in core/include/vdrive/axis_status.hpp and a member in "
          << "idl/vdrive_messages.idl";
    }
  }
  EXPECT_EQ(value_of(received, "profile_velocity"_object), std::nullopt);
}

TEST(ParameterConversion, ReadsEveryWritableObjectOfTheManual) {
  AxisConfiguration configuration;
  configuration.parameters = {{{0x607D, 1}, -70}, {{0x607D, 2}, 71}, {{0x6067, 0}, 72},
                              {{0x6068, 0}, 73},  {{0x607F, 0}, 74}, {{0x6080, 0}, 75},
                              {{0x6081, 0}, 76},  {{0x6083, 0}, 77}, {{0x6084, 0}, 78},
                              {{0x60C5, 0}, 79},  {{0x60C6, 0}, 80}, {{0x60E0, 0}, 81},
                              {{0x60E1, 0}, 82},  {{0x60F2, 0}, 1}};
  AxisBank bank({&configuration, 1}, std::chrono::milliseconds{1});
  ASSERT_EQ(bank.write(0, {0x607A, 0}, -83), AbortCode::none);
  ASSERT_EQ(bank.write(0, {0x6060, 0}, 1), AbortCode::none);
  ASSERT_EQ(bank.write(0, {0x6040, 0}, 6), AbortCode::none);

  msg::AxisParameters message;
  to_message(bank, 0, {.bench = 2, .axis = 5}, 99, message);

  EXPECT_EQ(message.bench, 2U);
  EXPECT_EQ(message.axis, 5U);
  EXPECT_EQ(message.tick, 99U);
  EXPECT_EQ(message.ds402_controlword, 6U);
  EXPECT_EQ(message.op_mode_cmd, 1);
  EXPECT_EQ(message.position_user_target_value, -83);
  EXPECT_EQ(message.user_position_lower_limit, -70);
  EXPECT_EQ(message.user_position_upper_limit, 71);
  EXPECT_EQ(message.position_target_reached_window, 72U);
  EXPECT_EQ(message.position_target_reached_window_time, 73U);
  EXPECT_EQ(message.app_speed_limit, 74U);
  EXPECT_EQ(message.motor_max_speed_rpm, 75U);
  EXPECT_EQ(message.profile_velocity, 76U);
  EXPECT_EQ(message.profile_acc, 77U);
  EXPECT_EQ(message.profile_dec, 78U);
  EXPECT_EQ(message.app_acc_limit, 79U);
  EXPECT_EQ(message.app_dec_limit, 80U);
  EXPECT_EQ(message.positive_torque_limit_relative, 81U);
  EXPECT_EQ(message.negative_torque_limit_relative, 82U);
  EXPECT_EQ(message.positioning_option_code, 1U);
}

TEST(ConvertUnit, KeepsAUnitThroughTheDescriptionOfAnAxis) {
  const Unit mm{.kind = UnitKind::linear, .name = "mm", .size = 1'000.5};
  msg::AxisDescription message;
  to_message(mm, message);
  EXPECT_EQ(message.unit_kind, msg::UnitKind::linear);
  EXPECT_EQ(unit_of(message), mm);
  to_message(Unit(), message);
  EXPECT_EQ(message.unit_kind, msg::UnitKind::rotary);
  EXPECT_EQ(message.unit_size, 4'096.0);
  EXPECT_EQ(unit_of(message), Unit());
}

TEST(ConvertUnit, ReplacesAnUnusableUnitByTheDefault) {
  msg::AxisDescription message;
  EXPECT_EQ(unit_of(message), Unit()) << "kind 0";
  message.unit_kind = msg::UnitKind::linear;
  message.unit_name = "mm";
  EXPECT_EQ(unit_of(message), Unit()) << "size 0";
  message.unit_size = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(unit_of(message), Unit());
  message.unit_size = 10.0;
  EXPECT_EQ(unit_of(message).name, "mm");
  message.unit_kind = static_cast<msg::UnitKind>(3);
  EXPECT_EQ(unit_of(message), Unit());
}

TEST(DescribeReason, HasTextsForReasonsAndAbortCodes) {
  EXPECT_EQ(describe_reason(number(msg::Reason::unknown_axis)), "no such axis");
  const std::string abort_code = describe_reason(0x06010002);
  EXPECT_TRUE(abort_code.starts_with("0x06010002, ")) << abort_code;
  EXPECT_FALSE(describe_reason(12'345).empty());
}

}  // namespace
}  // namespace vdrive::wire
