// SPDX-License-Identifier: Apache-2.0
#include "diagnostics.hpp"

#include "fake_benches.hpp"
#include "joint_publisher.hpp"

#include <gtest/gtest.h>

#include <string>

namespace vdrive::ros2 {
namespace {

/// A bench with joints x and y, enabled by the bridge.
struct Diagnosed : FakeBenches {
  Diagnosed() {
    add(1, {"x", "y"});
    enable();
  }

  /// @return the levels of the bench and its joints, and the message about x.
  std::string levels() {
    const auto array = diagnostics_of(benches.views(), "loopback only");
    std::string levels;
    for (const auto& status : array.status)
      levels += std::to_string(std::to_integer<int>(status.level));
    return levels + " " + array.status[1].message;
  }
};

TEST(Diagnostics, HaveALevelForTheBenchAndEachJoint) {
  Diagnosed fake;
  EXPECT_EQ(fake.levels(), "000 Operation enabled");
  const std::string before = levels_of(fake.benches.views());
  fake.drives.at(1).show(0, PowerState::switched_on);
  fake.turn();
  EXPECT_EQ(fake.levels(), "010 Switched on") << "a joint that is to be enabled is a warning";
  EXPECT_NE(levels_of(fake.benches.views()), before) << "a reader hears of it at once";
  fake.drives.at(1).show(0, PowerState::fault);
  fake.turn();
  EXPECT_EQ(fake.levels().substr(0, 3), "020");
}

TEST(Diagnostics, WarnOfAJointThatAnotherSessionControls) {
  Diagnosed fake;
  fake.drives.at(1).axis(0).owner_session = 0x0B;
  fake.turn();
  EXPECT_EQ(fake.levels(), "010 controlled by an unknown program, session 0x000000000000000b");
  fake.benches.all().at(1).bench->add_name(0x0B, {.program = "vdrive"});
  fake.turn();
  EXPECT_EQ(fake.levels(), "010 controlled by vdrive, session 0x000000000000000b");
  fake.benches.enable(false);
  EXPECT_EQ(fake.levels(), "000 Operation enabled") << "the bridge does not want it";
}

TEST(Diagnostics, AreStaleWhileTheBenchSendsNothing) {
  Diagnosed fake;
  fake.benches.all().at(1).bench->set_state(nullptr);
  (void)fake.motion().update(fake.time);
  EXPECT_EQ(fake.levels(), "333 its bench sends no status");
}

TEST(JointState, HasTheMeasuredValuesOfTheLoadAndNoEffortWithoutARating) {
  Diagnosed fake;
  AxisStatus& status = fake.drives.at(1).axis(1).status;
  status.load_position_actual_value = 500;
  status.load_velocity_actual_value = -250;
  status.torque_actual_value = 100;
  fake.turn();
  BenchView view = fake.benches.views().at(1);
  const auto message = joint_state_of(view);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->name[1], "y");
  EXPECT_DOUBLE_EQ(message->position[1], 0.5) << "500 units of 0.001 rad";
  EXPECT_DOUBLE_EQ(message->velocity[1], -0.25);
  EXPECT_DOUBLE_EQ(message->effort[1], 0.3) << "100 thousandths of 0.003 N.m";
  view.limits = nullptr;
  EXPECT_TRUE(joint_state_of(view)->effort.empty());
  view.state = nullptr;
  EXPECT_FALSE(joint_state_of(view));
}

}  // namespace
}  // namespace vdrive::ros2
