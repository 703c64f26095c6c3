// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"
#include "vdrive/wire/ros.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace vdrive::ros {
namespace {

// The hashes that ROS 2 nodes announce, taken from their logs, from `ros2 topic info --verbose` and
// from the sources of other implementations.
TEST(RosTypeHash, EqualsTheHashThatRosAnnounces) {
  const std::map<const char*, const char*> published{
      {"sensor_msgs/msg/JointState",
       "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"},
      {"trajectory_msgs/msg/JointTrajectory",
       "RIHS01_179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e"},
      {"std_msgs/msg/Bool",
       "RIHS01_feb91e995ff9ebd09c0cb3d2aed18b11077585839fb5db80193b62d74528f6c9"},
      {"std_msgs/msg/Header",
       "RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"},
      {"diagnostic_msgs/msg/DiagnosticArray",
       "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"},
      {"rcl_interfaces/msg/Log",
       "RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac"},
      {"rosgraph_msgs/msg/Clock",
       "RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564"}};
  for (const auto& [type, hash] : published) EXPECT_EQ(type_hash(type), hash) << type;
}

TEST(RosTypeHash, DescribesTypesInTheCanonicalForm) {
  EXPECT_EQ(type_description("std_msgs/msg/Bool"),
            R"({"type_description": {"type_name": "std_msgs/msg/Bool", "fields": [)"
            R"({"name": "data", "type": {"type_id": 15, "capacity": 0, "string_capacity": 0, )"
            R"("nested_type_name": ""}}]}, "referenced_type_descriptions": []})");
}

TEST(RosTypeHash, DiffersFromTypeToType) {
  const std::string time = type_hash("builtin_interfaces/msg/Time");
  EXPECT_EQ(time.size(), 7U + 64U);  // RIHS01_ and 256 bits
  EXPECT_NE(time, type_hash("builtin_interfaces/msg/Duration")) << "the name is part of it";
  EXPECT_THROW((void)type_hash("std_msgs/msg/Byte"), std::invalid_argument);
}

TEST(RosTopic, HasThePrefixOfRosAndAValidName) {
  EXPECT_EQ(dds_topic("/cell1/joint_states"), "rt/cell1/joint_states");
  EXPECT_EQ(check_topic("/cell1/joint_states"), "");
  for (const char* bad : {"", "joint_states", "/", "/a/", "//a", "/1a", "/a b", "/a-b", "/ä"}) {
    EXPECT_NE(check_topic(bad), "") << bad;
  }
}

/// @return the DDS name of a type: the full name of its generated class, as the compiler writes it.
template <typename Message>
std::string dds_type() {
  std::string_view text = __PRETTY_FUNCTION__;
  text.remove_prefix(text.find("Message = ") + std::string_view("Message = ").size());
  return std::string(text.substr(0, text.find_first_of(";]")));
}

// Authors of plain DDS programs rely on this table.
TEST(RosTopicsOfTheGuide, HaveTheirNamesAndTypesOnDds) {
  std::ifstream file(VDRIVE_SOURCE_DIR "/docs/guides/ros2.md");
  std::ostringstream page;
  page << file.rdbuf();
  ros2::Settings settings;
  ros2::resolve_topics(settings);
  const ros2::TopicNames& topics = settings.topics;
  // The topics that the bridge opens: clients/ros2/src/bridge.hpp and joint_publisher.hpp.
  const std::array rows{std::pair{topics.joint_states, dds_type<JointState>()},
                        std::pair{topics.joint_commands, dds_type<JointState>()},
                        std::pair{topics.joint_trajectory, dds_type<JointTrajectory>()},
                        std::pair{topics.enable, dds_type<Bool>()},
                        std::pair{topics.diagnostics, dds_type<DiagnosticArray>()},
                        std::pair{topics.rosout, dds_type<Log>()},
                        std::pair{topics.clock, dds_type<Clock>()}};
  for (const auto& [topic, type] : rows) {
    EXPECT_THAT(page.str(), testing::HasSubstr("| `" + topic + "` | `" + dds_topic(topic) +
                                               "` | `" + type + "` |"));
  }
}

}  // namespace
}  // namespace vdrive::ros
