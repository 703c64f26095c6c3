// SPDX-License-Identifier: Apache-2.0
#include "requests.hpp"

#include "joints.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>

namespace vdrive::ros2 {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Joints a, b and c are at places 0, 1 and 2 of bench 1.
std::optional<JointPlace> find_plain(const std::string& name, std::string& problem) {
  if (name.size() != 1 || name < "a" || name > "c") {
    problem = "is unknown; known: a, b, c";
    return std::nullopt;
  }
  return JointPlace{.bench = 1, .place = static_cast<std::size_t>(name[0] - 'a')};
}

/// The same, with c commanded by velocity and the others by position.
std::optional<JointPlace> find_declared(const std::string& name, std::string& problem) {
  auto joint = find_plain(name, problem);
  if (joint)
    joint->interface = name == "c" ? CommandInterface::velocity : CommandInterface::position;
  return joint;
}

ros::JointState state(std::vector<std::string> names, std::vector<double> positions,
                      std::vector<double> velocities = {}) {
  ros::JointState message;
  message.name = std::move(names);
  message.position = std::move(positions);
  message.velocity = std::move(velocities);
  return message;
}

std::string text(const JointCommands& read) {
  std::string text;
  for (const JointCommand& command : read.commands) {
    text += std::to_string(command.joint.place) + std::string(to_string(command.interface)) + "=" +
            std::to_string(static_cast<int>(command.value)) + " ";
  }
  return text;
}

TEST(JointCommands, AreOneForEachValue) {
  const auto read = read_commands(state({"c", "a"}, {3.0, 1.0}), find_plain);
  EXPECT_EQ(text(read), "2position=3 0position=1 ");
  EXPECT_THAT(read.problems, IsEmpty());
}

TEST(JointCommands, SkipValuesThatAreNotANumber) {
  const auto read = read_commands(state({"a", "b"}, {kNan, 2.0}), find_plain);
  EXPECT_EQ(text(read), "1position=2 ");
  EXPECT_THAT(read.problems, IsEmpty()) << "ros2_control sends such before its first command";
}

TEST(JointCommands, ReportUnknownJointsAndAcceptTheOthers) {
  const auto read = read_commands(state({"x", "b"}, {1.0, 2.0}), find_plain);
  EXPECT_EQ(text(read), "1position=2 ");
  EXPECT_THAT(read.problems, ElementsAre("joint 'x' is unknown; known: a, b, c: ignored"));
}

TEST(JointCommands, RefuseShortArraysOfJointsWithAnUnknownInterface) {
  const auto read = read_commands(state({"a", "b"}, {1.0}), find_plain);
  EXPECT_THAT(read.commands, IsEmpty());
  EXPECT_THAT(read.problems, ElementsAre(HasSubstr("position has 1 values for 2 names")));
}

TEST(JointCommands, AssignShortArraysToTheJointsWithTheInterface) {
  const auto read = read_commands(state({"a", "c", "b"}, {1.0, 2.0}, {7.0}), find_declared);
  EXPECT_EQ(text(read), "0position=1 2velocity=7 1position=2 ");
  EXPECT_THAT(read.problems, IsEmpty());
}

TEST(JointCommands, RefuseAJointWithTwoInterfaces) {
  const auto read = read_commands(state({"a", "b"}, {1.0, kNan}, {2.0, 3.0}), find_plain);
  EXPECT_EQ(text(read), "1velocity=3 ") << "b has one";
  EXPECT_THAT(read.problems, ElementsAre(HasSubstr("'a' has a position and a velocity: refused")));
}

TEST(JointCommands, IgnoreAnInterfaceThatTheConfigurationDoesNotAllow) {
  const auto read = read_commands(state({"c"}, {1.0}), find_declared);
  EXPECT_THAT(read.commands, IsEmpty());
  EXPECT_THAT(read.problems, ElementsAre(HasSubstr("'c' is commanded by velocity")));
}

TEST(JointCommands, IgnoreAJointThatIsNamedTwice) {
  const auto read = read_commands(state({"a", "a"}, {1.0, 2.0}), find_plain);
  EXPECT_EQ(text(read), "0position=1 ");
  EXPECT_THAT(read.problems, SizeIs(1));
}

ros::JointTrajectory trajectory(std::vector<std::string> names, const std::vector<double>& times) {
  ros::JointTrajectory message;
  const std::size_t joints = names.size();
  message.joint_names = std::move(names);
  for (const double time : times) {
    ros::JointTrajectoryPoint point;
    point.positions = std::vector<double>(joints, time);
    point.time_from_start.sec = static_cast<std::int32_t>(std::floor(time));
    point.time_from_start.nanosec =
        static_cast<std::uint32_t>(std::llround((time - std::floor(time)) * 1e9));
    message.points.push_back(point);
  }
  return message;
}

std::string problem_of(const ros::JointTrajectory& message, const FindJoint& find = find_plain) {
  std::string problem;
  const bool is_taken = read_trajectory(message, find, problem).has_value();
  EXPECT_EQ(is_taken, problem.empty());
  return problem;
}

TEST(Trajectory, HasItsJointsPointsAndTimes) {
  std::string problem;
  auto message = trajectory({"b", "a"}, {0.5, 1.25});
  message.header.stamp.sec = 3;
  message.header.stamp.nanosec = 7;
  const auto read = read_trajectory(message, find_plain, problem);
  ASSERT_TRUE(read) << problem;
  EXPECT_EQ(read->joints[0].place, 1U);
  EXPECT_DOUBLE_EQ(read->points[1].time, 1.25);
  EXPECT_EQ(read->start, 3'000'000'007);
}

TEST(Trajectory, IsRefusedWithTheReason) {
  EXPECT_THAT(problem_of(trajectory({}, {1.0})), HasSubstr("no joint"));
  EXPECT_THAT(problem_of(trajectory({"a"}, {})), HasSubstr("no points"));
  EXPECT_THAT(problem_of(trajectory({"x"}, {1.0})), HasSubstr("'x' is unknown; known: a, b, c"));
  EXPECT_THAT(problem_of(trajectory({"a", "a"}, {1.0})), HasSubstr("named twice"));
  EXPECT_THAT(problem_of(trajectory({"c"}, {1.0}), find_declared), HasSubstr("by velocity"));
  EXPECT_THAT(problem_of(trajectory({"a"}, {1.0, 1.0})), HasSubstr("times must increase"));
  EXPECT_THAT(problem_of(trajectory({"a"}, {2.0, 1.0})), HasSubstr("point 2 is at 1 s"));
  auto message = trajectory({"a"}, {1.0});
  message.points[0].positions[0] = kNan;
  EXPECT_THAT(problem_of(message), HasSubstr("positions that are not numbers"));
  message = trajectory({"a"}, {1.0});
  message.points[0].velocities = {1.0, 2.0};
  EXPECT_THAT(problem_of(message), HasSubstr("2 velocities for 1 joints"));
  message.points[0].velocities = {1.0};
  EXPECT_THAT(problem_of(message), HasSubstr("the last point has a velocity, which must be 0"));
  message = trajectory({"a"}, {1.0});
  message.points[0].effort = {1.0};
  EXPECT_THAT(problem_of(message), HasSubstr("effort"));
}

client::BenchInfo bench(std::uint32_t number) {
  client::BenchInfo info;
  info.number = number;
  info.axes = {{.id = {number, 1}, .name = "x", .unit = {}},
               {.id = {number, 2},
                .name = "lift",
                .unit = {.kind = client::UnitKind::linear, .name = "mm", .size = 100.0}}};
  return info;
}

TEST(Joints, HaveTheNamesAndUnitsOfTheAxes) {
  const auto joints = joints_of(bench(1), {});
  EXPECT_EQ(joints[0].name, "x");
  EXPECT_STREQ(joints[0].unit_name(), "rad");
  EXPECT_DOUBLE_EQ(joints[0].si_per_user_unit, 2.0 * std::numbers::pi / 4096.0);
  EXPECT_STREQ(joints[1].unit_name(), "m");
  EXPECT_DOUBLE_EQ(joints[1].si_per_user_unit, 1e-5);  // 100 UU are 1 mm
}

TEST(Joints, HaveTheNamesOfTheConfiguration) {
  Settings settings;
  settings.joints = {{.name = "shoulder", .axis = "1.1"},
                     {.name = "z", .axis = "1.lift", .interface = CommandInterface::velocity}};
  const auto joints = joints_of(bench(1), settings);
  EXPECT_EQ(joints[0].name, "shoulder");
  EXPECT_EQ(joints[1].name, "z");
  EXPECT_EQ(joints[1].interface, CommandInterface::velocity);
  settings.is_prefixed = true;
  EXPECT_EQ(joints_of(bench(2), settings)[0].name, "bench2_x");
}

TEST(Joints, OfTwoBenchesNeedDifferentNames) {
  JointDirectory directory;
  EXPECT_FALSE(directory.add(1, joints_of(bench(1), {})));
  const auto clash = directory.add(2, joints_of(bench(2), {}));
  ASSERT_TRUE(clash);
  EXPECT_THAT(*clash, HasSubstr("bench 2 is left out: its joint \"x\" is also on bench 1"));
  EXPECT_EQ(directory.find("lift")->bench, 1U);
  directory.remove(1);
  EXPECT_FALSE(directory.find("x"));
  EXPECT_FALSE(directory.add(2, joints_of(bench(2), {})));
}

TEST(Joints, ThatAreUnknownGetTheNearestNameAndTheFirstKnownOnes) {
  JointDirectory sut;
  EXPECT_EQ(sut.unknown("lifr"), "is unknown: no bench is served yet");
  ASSERT_FALSE(sut.add(1, joints_of(bench(1), {})));
  EXPECT_EQ(sut.unknown("lifr"), "is unknown (did you mean 'lift'?); known: lift, x");
  EXPECT_EQ(sut.unknown("elbow"), "is unknown; known: lift, x");
  sut.remove(1);
  EXPECT_EQ(sut.unknown("lifr"), "is unknown: no bench is served yet") << "of the joints of now";
}

// The message lists 8 of the 1,000 names; the suggestion is chosen from all of them.
TEST(Joints, ThatAreUnknownGetAMessageOfBoundedLength) {
  JointDirectory sut;
  std::vector<ServedJoint> many;
  for (int i = 1000; i < 2000; ++i) many.emplace_back().name = "joint_" + std::to_string(i);
  ASSERT_FALSE(sut.add(1, many));
  EXPECT_EQ(sut.unknown("joint_1755x"),
            "is unknown (did you mean 'joint_1755'?); known: joint_1000, joint_1001, joint_1002, "
            "joint_1003, joint_1004, joint_1005, joint_1006, joint_1007 and 992 more");
  for (int i = 0; i < 1000; ++i) (void)sut.unknown("wheel_" + std::to_string(i));
  EXPECT_THAT(sut.unknown("joint_1755x"), HasSubstr("did you mean 'joint_1755'"));
}

}  // namespace
}  // namespace vdrive::ros2
