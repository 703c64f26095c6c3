// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/conversion.hpp"

#include "vdrive/dictionary/dictionary.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <tuple>

namespace vdrive::wire {
namespace {

using namespace vdrive::literals;

AxisStatus status_with_distinct_values() {
  return {.position_demand_value = -101,
          .load_position_actual_value = 102,
          .load_position_error_value = -103,
          .motor_position_actual_value = 104,
          .motor_position_error_value = -105,
          .velocity_demand_value = 106,
          .load_velocity_actual_value = -107,
          .load_velocity_error_value = 108,
          .motor_velocity_actual_value = -109,
          .motor_velocity_error_value = 110,
          .current_error_value = -111,
          .current_actual_value = 112,
          .torque_actual_value = -113,
          .torque_demand = 114,
          .ds402_statusword = 0x1637,
          .error_code = 0x8611,
          .op_mode_actual = -4,
          .motor_op_status = 1,
          .error_register = 0x21,
          .digital_inputs = 5,
          .ignored_set_points = 115,
          .fault_count = 116};
}

auto values_of(const AxisStatus& s) {
  return std::make_tuple(
      s.position_demand_value, s.load_position_actual_value, s.load_position_error_value,
      s.motor_position_actual_value, s.motor_position_error_value, s.velocity_demand_value,
      s.load_velocity_actual_value, s.load_velocity_error_value, s.motor_velocity_actual_value,
      s.motor_velocity_error_value, s.current_error_value, s.current_actual_value,
      s.torque_actual_value, s.torque_demand, s.ds402_statusword, s.error_code, s.op_mode_actual,
      s.motor_op_status, s.error_register, s.digital_inputs, s.ignored_set_points, s.fault_count);
}

TEST(StatusConversion, GivesBackEveryValue) {
  const AxisStatus status = status_with_distinct_values();
  msg::AxisStatus message;
  to_message(status, {.bench = 7, .axis = 3}, 42, {.session = 9, .epoch = 8, .last_sequence = 6},
             message);
  EXPECT_EQ(values_of(from_message(message)), values_of(status));
  EXPECT_EQ(message.bench(), 7U);
  EXPECT_EQ(message.axis(), 3U);
  EXPECT_EQ(message.tick(), 42U);
  EXPECT_EQ(message.owner_session(), 9U);
  EXPECT_EQ(message.owner_epoch(), 8U);
  EXPECT_EQ(message.last_sequence(), 6U);
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
  EXPECT_EQ(values_of(from_message(message)), values_of(status));
}

TEST(StatusConversion, ForgetsTheObjectsOfAnEarlierUse) {
  msg::AxisStatus message;
  message.objects().resize(3);
  to_message(AxisStatus{}, {}, 0, {}, message);
  EXPECT_TRUE(message.objects().empty());
}

TEST(ValueOf, FindsTheMembersByTheirObject) {
  msg::AxisStatus message;
  to_message(status_with_distinct_values(), {}, 0, {}, message);
  EXPECT_EQ(value_of(message, "ds402_statusword"_object), 0x1637);
  EXPECT_EQ(value_of(message, "op_mode_actual"_object), -4);
  EXPECT_EQ(value_of(message, "current_error_value"_object), -111);
  EXPECT_EQ(value_of(message, "torque_actual_value"_object), -113);
  EXPECT_EQ(value_of(message, "profile_velocity"_object), std::nullopt);
}

TEST(ValueOf, FindsEveryMonitoredObjectOfTheManual) {
  const msg::AxisStatus message;
  for (ObjectRow row = 0; row < kObjectCount; ++row) {
    const auto& object = describe(row);
    if (object.origin == Origin::manual && object.access == Access::read_only) {
      EXPECT_TRUE(value_of(message, row).has_value()) << object.variable_name;
    }
  }
}

TEST(ValueOf, FindsFurtherObjectsByTheirAddress) {
  msg::AxisStatus message;
  auto& object = message.objects().emplace_back();
  object.index(0x607D);
  object.subindex(2);
  object.value(-5);
  EXPECT_EQ(value_of(message, "user_position_upper_limit"_object), -5);
  EXPECT_EQ(value_of(message, "user_position_lower_limit"_object), std::nullopt);
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

  EXPECT_EQ(message.bench(), 2U);
  EXPECT_EQ(message.axis(), 5U);
  EXPECT_EQ(message.tick(), 99U);
  EXPECT_EQ(message.ds402_controlword(), 6U);
  EXPECT_EQ(message.op_mode_cmd(), 1);
  EXPECT_EQ(message.position_user_target_value(), -83);
  EXPECT_EQ(message.user_position_lower_limit(), -70);
  EXPECT_EQ(message.user_position_upper_limit(), 71);
  EXPECT_EQ(message.position_target_reached_window(), 72U);
  EXPECT_EQ(message.position_target_reached_window_time(), 73U);
  EXPECT_EQ(message.app_speed_limit(), 74U);
  EXPECT_EQ(message.motor_max_speed_rpm(), 75U);
  EXPECT_EQ(message.profile_velocity(), 76U);
  EXPECT_EQ(message.profile_acc(), 77U);
  EXPECT_EQ(message.profile_dec(), 78U);
  EXPECT_EQ(message.app_acc_limit(), 79U);
  EXPECT_EQ(message.app_dec_limit(), 80U);
  EXPECT_EQ(message.positive_torque_limit_relative(), 81U);
  EXPECT_EQ(message.negative_torque_limit_relative(), 82U);
  EXPECT_EQ(message.positioning_option_code(), 1U);
}

TEST(DescribeReason, HasWordsForReasonsAndAbortCodes) {
  EXPECT_EQ(describe_reason(msg::REASON_UNKNOWN_AXIS), "no such axis");
  const std::string abort_code = describe_reason(0x06010002);
  EXPECT_TRUE(abort_code.starts_with("0x06010002, ")) << abort_code;
  EXPECT_FALSE(describe_reason(12'345).empty());
}

}  // namespace
}  // namespace vdrive::wire
