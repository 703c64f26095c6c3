// SPDX-License-Identifier: Apache-2.0
#include "joint_plan.hpp"

#include "fake_bench.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace vdrive::ros2 {
namespace {

/// The plan of an enabled joint that rests at 0, and the drive behind it.
struct Planned {
  FakeBench drives{{"x"}};
  ServedJoint joint{drives.joints()[0]};
  JointLimits limits{FakeBench::limits()};
  JointPlan plan{};

  Planned() { drives.enable(); }

  JointNow now() {
    return {.joint = joint,
            .axis = drives.axis(0),
            .limits = limits,
            .tick = drives.tick(),
            .period = 0.001};
  }

  /// Sends the position of the next tick and passes it.
  void step() {
    client::SetPointFrame frame{.tick = drives.tick() + 1};
    frame.axes.push_back(plan.position_point(now(), frame.tick));
    (void)drives.take({frame});
    drives.step();
  }
};

TEST(JointPlan, GoesToAPositionInTheModeOfPositionsAndHoldsIt) {
  Planned joint;
  EXPECT_TRUE(joint.plan.go_to(joint.now(), 0.1));
  const auto first = joint.plan.position_point(joint.now(), joint.drives.tick() + 1);
  EXPECT_EQ(first.mode, OperatingMode::cyclic_synchronous_position);
  for (int tick = 0; tick < 1'000 && joint.plan.has_positions(); ++tick) joint.step();
  EXPECT_EQ(joint.plan.duty(), Duty::hold);
  EXPECT_EQ(joint.drives.axis(0).status.position_demand_value, 100) << "0.1 rad of 0.001 rad";
  EXPECT_EQ(joint.plan.motion(joint.now(), joint.drives.tick()).position, 0.1);
  EXPECT_FALSE(joint.plan.go_to(joint.now(), 0.1)) << "it is there";
}

TEST(JointPlan, ComesToRestBeforeItFollowsPositions) {
  Planned joint;
  joint.plan.run(joint.now(), Duty::velocity, 1.0);
  joint.drives.axis(0).status.velocity_demand_value = 1000;
  EXPECT_TRUE(joint.plan.moves_by_itself(joint.now()));
  EXPECT_FALSE(joint.plan.go_to(joint.now(), 0.1)) << "no position is sent yet";
  EXPECT_EQ(joint.plan.duty(), Duty::settle);
  EXPECT_FALSE(joint.plan.settles(joint.now()));
  const auto mode = joint.plan.mode_point(joint.now(), joint.drives.tick() + 20);
  ASSERT_TRUE(mode);
  EXPECT_EQ(mode->mode, OperatingMode::cyclic_synchronous_position);
  EXPECT_FALSE(mode->position);
  EXPECT_FALSE(joint.plan.mode_point(joint.now(), joint.drives.tick() + 20)) << "it is on its way";
  (void)joint.drives.take({{.axes = {*mode}}});
  joint.drives.step();
  EXPECT_TRUE(joint.plan.settles(joint.now()));
  EXPECT_EQ(joint.plan.duty(), Duty::track);
}

TEST(JointPlan, SendsAVelocityOnceAndAgainWhereTheDriveDidNotTakeIt) {
  Planned joint;
  joint.plan.run(joint.now(), Duty::velocity, 1.5);
  const std::uint64_t reached = joint.drives.tick() + 3;
  const auto point = joint.plan.free_point(joint.now(), reached);
  ASSERT_TRUE(point);
  EXPECT_EQ(point->mode, OperatingMode::profile_velocity);
  EXPECT_EQ(point->velocity, 1500) << "1.5 rad/s of 0.001 rad/s";
  EXPECT_FALSE(joint.plan.free_point(joint.now(), reached));
  for (int tick = 0; tick < 4; ++tick) joint.drives.step();
  EXPECT_TRUE(joint.plan.free_point(joint.now(), joint.drives.tick() + 3))
      << "its tick has passed, and 6061h shows another mode";
}

TEST(JointPlan, SendsAnEffortInThousandthsOfTheRatedTorque) {
  Planned joint;
  joint.plan.run(joint.now(), Duty::effort, -1.5);
  const auto point = joint.plan.free_point(joint.now(), joint.drives.tick() + 1);
  ASSERT_TRUE(point);
  EXPECT_EQ(point->mode, OperatingMode::profile_torque);
  EXPECT_EQ(point->torque, -500) << "-1.5 N.m of 0.003 N.m";
}

TEST(JointPlan, BrakesWhatVelocityOrEffortMoveAndNothingElse) {
  Planned joint;
  EXPECT_FALSE(joint.plan.brake_free());
  joint.plan.run(joint.now(), Duty::velocity, 0.0);
  EXPECT_FALSE(joint.plan.brake_free()) << "it rests";
  joint.plan.run(joint.now(), Duty::effort, 1.0);
  EXPECT_TRUE(joint.plan.brake_free());
  EXPECT_EQ(joint.plan.duty(), Duty::velocity);
}

TEST(JointPlan, BrakesOnceWithoutACommandInTime) {
  Planned joint;
  joint.plan.run(joint.now(), Duty::velocity, 1.0);
  for (int tick = 0; tick < 100; ++tick) joint.drives.step();
  EXPECT_FALSE(joint.plan.brake_without_command(joint.now(), 0.1)) << "0.1 s are not over";
  joint.drives.step();
  EXPECT_TRUE(joint.plan.brake_without_command(joint.now(), 0.1));
  EXPECT_FALSE(joint.plan.brake_without_command(joint.now(), 0.1));
  EXPECT_EQ(joint.plan.free_point(joint.now(), joint.drives.tick() + 1)->velocity, 0);
}

TEST(JointPlan, StartsAgainWhereTheDriveHolds) {
  Planned joint;
  EXPECT_TRUE(joint.plan.go_to(joint.now(), 0.1));
  for (int tick = 0; tick < 10; ++tick) joint.step();
  const double held = joint.now().demand().position;
  joint.drives.count_from(joint.drives.tick() + 50);
  EXPECT_EQ(joint.plan.start_again(joint.now()), 0U) << "it follows no trajectory";
  const JointMotion motion = joint.plan.motion(joint.now(), joint.drives.tick());
  EXPECT_EQ(motion.position, held);
  EXPECT_EQ(motion.velocity, 0.0);
  for (int tick = 0; tick < 1'000 && joint.plan.has_positions(); ++tick) joint.step();
  EXPECT_EQ(joint.drives.axis(0).status.position_demand_value, 100) << "its goal is the same";
}

TEST(JointPlan, EndsATrajectoryThatTheBenchHasOvertaken) {
  Planned joint;
  const std::vector<PathPoint> points{{.time = 1.0, .position = 1.0}};
  joint.plan.follow(joint.now(), std::make_shared<const JointPath>(JointMotion{}, points),
                    joint.drives.tick(), 7);
  EXPECT_EQ(joint.plan.trajectory(), 7U);
  for (int tick = 0; tick < 500; ++tick) joint.step();
  EXPECT_EQ(joint.drives.axis(0).status.position_demand_value, 500) << "half of the line";
  joint.drives.count_from(joint.drives.tick() + 50);
  EXPECT_EQ(joint.plan.start_again(joint.now()), 7U);
  EXPECT_EQ(joint.plan.duty(), Duty::hold);
  EXPECT_EQ(joint.plan.motion(joint.now(), 0).position, 0.5);
}

TEST(JointPlan, GetsItsLastSetPointAgainUpToEightTimes) {
  Planned joint;
  EXPECT_TRUE(joint.plan.go_to(joint.now(), 0.1));
  for (int repeat = 0; repeat <= 8; ++repeat) {
    while (joint.plan.has_positions()) {
      (void)joint.plan.position_point(joint.now(), joint.drives.tick() + 1);  // lost
      joint.drives.step();
    }
    EXPECT_EQ(joint.plan.check_end(joint.now()), JointPlan::End::open) << "its tick is now";
    joint.drives.step();
    const JointPlan::End expected = repeat < 8 ? JointPlan::End::refused : JointPlan::End::given_up;
    ASSERT_EQ(joint.plan.check_end(joint.now()), expected) << repeat;
    if (expected == JointPlan::End::refused) joint.plan.repeat_end(joint.now());
  }
  EXPECT_EQ(joint.plan.check_end(joint.now()), JointPlan::End::open) << "it is said once";
  EXPECT_TRUE(joint.plan.go_to(joint.now(), 0.1)) << "a command that is repeated is tried again";
}

TEST(JointPlan, ThatReachedItsEndIsChecked) {
  Planned joint;
  EXPECT_TRUE(joint.plan.go_to(joint.now(), 0.1));
  while (joint.plan.has_positions()) joint.step();
  joint.drives.step();
  EXPECT_EQ(joint.plan.check_end(joint.now()), JointPlan::End::reached);
}

}  // namespace
}  // namespace vdrive::ros2
