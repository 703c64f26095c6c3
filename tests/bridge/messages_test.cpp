// SPDX-License-Identifier: Apache-2.0
// Schemas and bytes of the messages published by bridges.
#include "messages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <sstream>

namespace vdrive::bridge {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string bytes_of(const std::vector<int>& numbers) {
  return {numbers.begin(), numbers.end()};
}

/// @return the fields of the schema's main type, such as "int32 position_demand_value".
std::vector<std::string> fields_of(const MessageSchema& schema) {
  std::vector<std::string> fields;
  std::istringstream text(schema.text);
  for (std::string line; std::getline(text, line) && line.find("===") != 0;) fields.push_back(line);
  return fields;
}

TEST(Schemas, HaveEveryPublishedMemberOfTheStatus) {
  const auto axis = fields_of(axis_status_schema());
  const auto bench = fields_of(bench_status_schema());
  const auto trace = fields_of(axis_trace_schema());
  std::size_t published = 0;
  for (const StatusMember& member : status_members()) {
    const auto ends = [&](const std::string& field) {
      return field.ends_with(" " + std::string(member.name));
    };
    const auto expected = member.is_published ? 1 : 0;
    EXPECT_EQ(std::ranges::count_if(axis, ends), expected) << member.name;
    EXPECT_EQ(std::ranges::count_if(bench, ends), expected) << member.name;
    EXPECT_EQ(std::ranges::count_if(trace, ends), expected) << member.name;
    published += member.is_published ? 1U : 0U;
  }
  EXPECT_EQ(axis.size(), published + 6);
  EXPECT_THAT(axis, testing::Contains("uint16 ds402_statusword"));
  EXPECT_THAT(bench, testing::Contains("int8[] op_mode_actual"));
  EXPECT_THAT(trace, testing::Contains("uint64[] tick"));
}

TEST(Schemas, AreTheTextOfTheirFields) {
  const std::string line(80, '=');
  EXPECT_EQ(joint_states_schema().text,
            "builtin_interfaces/Time timestamp\nfoxglove_msgs/JointState[] joints\n" + line +
                "\nMSG: foxglove_msgs/JointState\nstring name\nfloat64 position\n"
                "float64 velocity\nfloat64 acceleration\nfloat64 effort\n" +
                line + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n");
  EXPECT_EQ(log_schema().text,
            "uint8 UNKNOWN=0\nuint8 DEBUG=1\nuint8 INFO=2\nuint8 WARNING=3\nuint8 ERROR=4\n"
            "uint8 FATAL=5\nbuiltin_interfaces/Time timestamp\nuint8 level\nstring message\n"
            "string name\nstring file\nuint32 line\n" +
                line + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n");
}

TEST(Schemas, IncludeTheTypesThatTheyUse) {
  const std::string line(80, '=');
  for (const MessageSchema& schema : {axis_status_schema(), bench_status_schema(),
                                      axis_trace_schema(), log_schema(), joint_states_schema()}) {
    EXPECT_THAT(schema.text, HasSubstr(line + "\nMSG: builtin_interfaces/Time\n")) << schema.name;
  }
  EXPECT_THAT(joint_states_schema().text, HasSubstr(line + "\nMSG: foxglove_msgs/JointState\n"));
}

client::Observation observation() {
  client::Observation observed;
  observed.tick = 5;
  observed.axes.resize(2);
  for (std::size_t i = 0; i < 2; ++i) {
    observed.axes[i].id = {1, static_cast<std::uint16_t>(i + 1)};
    observed.axes[i].tick = 5;
    observed.axes[i].status.position_demand_value = -7 - static_cast<std::int32_t>(i);
  }
  return observed;
}

TEST(Messages, BeginWithTimeTickAndAxes) {
  // 1.5 s = 1 s and 500,000,000 ns = 0x1DCD6500.
  const std::string bytes = encode_bench_status(observation(), 1'500'000'000);
  EXPECT_THAT(bytes,
              StartsWith(bytes_of({0,    1,   0, 0,                                      //
                                   1,    0,   0, 0, 0x00, 0x65, 0xCD, 0x1D,              // time
                                   5,    0,   0, 0, 0,    0,    0,    0,                 // tick
                                   2,    0,   0, 0, 1,    0,    2,    0,                 // axes
                                   2,    0,   0, 0, 0xF9, 0xFF, 0xFF, 0xFF, 0xF8, 0xFF,  // 6062h
                                   0xFF, 0xFF})));
}

TEST(Messages, HaveOneElementForEachTickOfATrace) {
  Trace trace{.axis = 2, .missed = 3, .ticks = {8, 9}, .status = {{}, {}}};
  trace.status[1].position_demand_value = 1;
  EXPECT_THAT(encode_axis_trace(trace, 0),
              StartsWith(bytes_of({0, 1, 0, 0,              //
                                   0, 0, 0, 0, 0, 0, 0, 0,  // time
                                   2, 0, 0, 0, 0, 0, 0, 0,  // axis, padding
                                   3, 0, 0, 0, 0, 0, 0, 0,  // missed
                                   2, 0, 0, 0, 0, 0, 0, 0,  // ticks, padding
                                   8, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0,  //
                                   2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0})));          // 6062h
}

/// @return position, velocity, acceleration and effort of the first joint in a message.
std::array<double, 4> numbers_of_first_joint(const std::string& bytes) {
  std::array<double, 4> numbers{};
  // Header 4, time 8, count 4, name 4 + 2 bytes; the 18 bytes after the header are padded to 24.
  constexpr std::size_t kFirst = 28;
  if (bytes.size() >= kFirst + sizeof(numbers)) {
    std::memcpy(numbers.data(), bytes.data() + kFirst, sizeof(numbers));
  }
  return numbers;
}

TEST(Messages, HaveJointsInSiUnits) {
  client::Observation observed = observation();
  observed.axes[0].status.load_position_actual_value = 1024;
  const double rad = si_per_user_unit(Unit{});  // 4096 UU per revolution
  const std::vector<Joint> joints(2, Joint{.name = "x", .scale = {.si_per_user_unit = rad}});
  const std::string bytes = encode_joint_states(observed, joints, 0);
  EXPECT_DOUBLE_EQ(numbers_of_first_joint(bytes)[0], 1.5707963267948966)
      << "a quarter of a revolution";
}

TEST(Messages, HaveTheEffortOfTheLoadAndNoAcceleration) {
  client::Observation observed = observation();
  observed.axes[0].status.torque_actual_value = -500;
  const Unit turns{};  // 4096 UU per revolution: the angle of the load
  // 3 N.m rated, half of it in negative direction; 10 turns of the motor are 1 turn of the load.
  const double effort = effort_per_mille(
      turns,
      {.motor_rated_torque = 3'000, .gear_ratio_numerator = 1, .gear_ratio_denominator = 10});
  const std::vector<Joint> joints(
      2, Joint{.name = "x",
               .scale = {.si_per_user_unit = si_per_user_unit(turns), .effort_per_mille = effort}});
  const auto numbers = numbers_of_first_joint(encode_joint_states(observed, joints, 0));
  EXPECT_NEAR(numbers[3], -15.0, 1e-12) << "1.5 N.m of the motor, times 10";
  EXPECT_TRUE(std::isnan(numbers[2]));
  const std::vector<Joint> unread(2, Joint{.name = "x", .scale = {.si_per_user_unit = 1.0}});
  EXPECT_TRUE(std::isnan(numbers_of_first_joint(encode_joint_states(observed, unread, 0))[3]));
}

TEST(Messages, HaveTheEffortOfALinearAxisInNewton) {
  // 4096 UU per turn of the screw, 409.6 UU per millimetre: a pitch of 10 mm.
  const Unit screw{.kind = UnitKind::linear, .name = "mm", .size = 409.6};
  const TorqueRating rating{.motor_rated_torque = 1'000};
  // 1 N.m through 2 pi rad does the same work as 200 pi N through 0.01 m.
  EXPECT_NEAR(1'000.0 * effort_per_mille(screw, rating), 628.318530717958647, 1e-9);
  // 409.6 UU per revolution: the axis makes 10 turns per turn of the load.
  const Unit fast{.size = 409.6};
  EXPECT_NEAR(1'000.0 * effort_per_mille(fast, rating), 0.1, 1e-12);
}

TEST(Messages, HaveLengthsInMetresAndOtherUnitsUnchanged) {
  const Unit millimetres{.kind = UnitKind::linear, .name = "mm", .size = 1000.0};
  EXPECT_DOUBLE_EQ(si_per_user_unit(millimetres), 1.0e-6) << "1000 UU are a millimetre";
  const Unit percent{.kind = UnitKind::linear, .name = "%", .size = 50.0};
  EXPECT_DOUBLE_EQ(si_per_user_unit(percent), 0.02);
}

}  // namespace
}  // namespace vdrive::bridge
