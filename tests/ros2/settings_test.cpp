// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"

#include "settings/configuration_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace vdrive::ros2 {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

Settings read(const std::string& text) {
  Settings settings;
  read_settings(text, "ros2.yaml", settings);
  resolve_topics(settings);
  return settings;
}

std::string problem_of_settings(const std::string& text) {
  try {
    (void)read(text);
  } catch (const settings::ConfigurationError& error) {
    return error.what();
  }
  return {};
}

TEST(RosSettings, HaveTheTopicsOfRosByDefault) {
  const Settings settings = read("");
  EXPECT_EQ(settings.topics.joint_states, "/joint_states");
  EXPECT_EQ(settings.topics.joint_commands, "/robot_joint_commands");
  EXPECT_EQ(settings.topics.rosout, "/rosout");
  EXPECT_EQ(settings.rate, 100.0);
  EXPECT_EQ(settings.stamp_ahead, 60.0);
  EXPECT_FALSE(settings.is_enabled);
}

TEST(RosSettings, AreReadFromTheFile) {
  const Settings settings = read(
      "benches: [1, 3]\nnamespace: cell1\nrate: 250\nenable: true\nprefix_benches: true\n"
      "command_timeout: 0.5\nstart_tolerance: 0.1\nstamp_ahead: 5\n"
      "topics:\n  joint_states: robot_joint_states\n  clock: /sim/clock\n"
      "joints:\n  shoulder: \"1.1\"\n  wheel: {axis: 1.w, interface: velocity}\n");
  EXPECT_THAT(settings.benches, ElementsAre(1U, 3U));
  EXPECT_EQ(settings.topics.joint_states, "/cell1/robot_joint_states");
  EXPECT_EQ(settings.topics.clock, "/sim/clock") << "begins with a slash: no namespace";
  EXPECT_EQ(settings.topics.diagnostics, "/diagnostics");
  EXPECT_EQ(settings.rate, 250.0);
  EXPECT_TRUE(settings.is_enabled);
  EXPECT_TRUE(settings.is_prefixed);
  EXPECT_EQ(settings.command_timeout, 0.5);
  EXPECT_EQ(settings.start_tolerance, 0.1);
  EXPECT_EQ(settings.stamp_ahead, 5.0);
  ASSERT_EQ(settings.joints.size(), 2U);
  EXPECT_EQ(settings.joints[0].name, "shoulder");
  EXPECT_EQ(settings.joints[0].axis, "1.1");
  EXPECT_EQ(settings.joints[1].interface, CommandInterface::velocity);
}

TEST(RosSettings, AreOneDocumentInUtf8WithoutTabs) {
  EXPECT_EQ(problem_of_settings("enable: true\n\trate: 5\n"),
            "ros2.yaml:2: this line is indented with a tab; YAML allows only spaces");
  EXPECT_THAT(problem_of_settings("rate: 5\nnamespace: \xff\n"),
              HasSubstr("ros2.yaml:2: 'namespace: \\xFF' is not valid UTF-8"));
  EXPECT_THAT(problem_of_settings("rate: 5\n---\nrate: 6\n"),
              HasSubstr("ros2.yaml:2: a second YAML document begins here"));
}

TEST(RosSettings, NestedWithoutEndAreRefused) {
  EXPECT_THAT(problem_of_settings("joints: " + std::string(1'000'000, '[')),
              HasSubstr("ros2.yaml:1: "));
}

TEST(RosSettings, NameFileLineKeyValueAndLimitOfAnError) {
  EXPECT_THAT(problem_of_settings("enable: true\nrate: 5000\n"),
              HasSubstr("ros2.yaml:2: rate = 5000: must be from 1 to 1000 Hz"));
  EXPECT_THAT(problem_of_settings("rates: 5\n"),
              AllOf(HasSubstr("ros2.yaml:1: rates"), HasSubstr("rate,")));
  EXPECT_THAT(problem_of_settings("enable: maybe\n"), HasSubstr("must be one of false, true"));
  EXPECT_THAT(problem_of_settings("topics:\n  clock: a b\n"),
              HasSubstr("ros2.yaml:2: topics.clock = a b: is not the name of a topic"));
  EXPECT_THAT(problem_of_settings("joints:\n  a: {interface: speed, axis: 1.1}\n"),
              HasSubstr("joints.a.interface = speed: must be one of position, velocity, effort"));
  EXPECT_THAT(problem_of_settings("joints:\n  a: {interface: velocity}\n"), HasSubstr("axis"));
  EXPECT_THAT(problem_of_settings("joints:\n  a: 1.1\n  b: 1.1\n"),
              HasSubstr("ros2.yaml:3: joints.b"));
  EXPECT_THAT(problem_of_settings("stamp_ahead: -1\n"), HasSubstr("from 0 to 86400 s"));
  EXPECT_THAT(problem_of_settings("benches: [0]\n"), HasSubstr("from 1 to 65535"));
  EXPECT_THAT(problem_of_settings("rate: 1\nrate: 2\n"), HasSubstr("the key appears twice"));
  EXPECT_THAT(problem_of_settings("rate: [\n"), HasSubstr("ros2.yaml:"));
  EXPECT_THAT(problem_of_settings("- 1\n"), HasSubstr("must be a map"));
  EXPECT_THAT(problem_of_settings("namespace: 1cell\n"), HasSubstr("is not the name of a topic"));
  EXPECT_THAT(problem_of_settings("topics: {clock: enable}\n"), HasSubstr("two topics are called"));
}

}  // namespace
}  // namespace vdrive::ros2
