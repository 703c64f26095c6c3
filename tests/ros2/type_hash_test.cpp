// SPDX-License-Identifier: Apache-2.0
#include "vdrive/wire/ros.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace vdrive::wire::ros {
namespace {

// Published by ROS 2 for its own type: docs of rmw, and what its nodes announce.
TEST(RosTypeHash, OfJointStateIsTheOneThatRosAnnounces) {
  EXPECT_EQ(type_hash("sensor_msgs/msg/JointState"),
            "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e");
}

// The same of two types that nearly every node announces.
TEST(RosTypeHash, OfLogAndClockAreThoseThatRosAnnounces) {
  EXPECT_EQ(type_hash("rcl_interfaces/msg/Log"),
            "RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac");
  EXPECT_EQ(type_hash("rosgraph_msgs/msg/Clock"),
            "RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564");
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

TEST(RosTopic, HasThePrefixOfTopicsAndTheNamesThatRosHas) {
  EXPECT_EQ(dds_topic("/cell1/joint_states"), "rt/cell1/joint_states");
  EXPECT_EQ(check_topic("/cell1/joint_states"), "");
  for (const char* bad : {"", "joint_states", "/", "/a/", "//a", "/1a", "/a b", "/a-b", "/ä"}) {
    EXPECT_NE(check_topic(bad), "") << bad;
  }
}

}  // namespace
}  // namespace vdrive::wire::ros
