// SPDX-License-Identifier: Apache-2.0
#include "joint_plan.hpp"

#include "fake_bench.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace vdrive::ros2 {
namespace {

/// The plan of an enabled joint at rest at 0, and its drive.
struct Planned {
  FakeBench drives{{"x"}};
  ServedJoint joint{drives.joints()[0]};
  JointLimits limits{FakeBench::limits()};
  JointPlan plan{};

  Planned() { drives.enable(); }

  JointCycle now() {
    return {.joint = joint,
            .axis = drives.axis(0),
            .limits = limits,
            .tick = drives.tick(),
            .period = 0.001};
  }

  /// Runs the tick in which the drive changes to the mode of the task.
  void enter() {
    const auto mode = plan.mode_point(now(), drives.tick() + 1);
    ASSERT_TRUE(mode);
    (void)drives.take({{.axes = {*mode}}});
    drives.step();
    EXPECT_TRUE(plan.settles(now()));
  }

  /// Sends the set-point of the next tick and runs that tick.
  void step() {
    client::SetPointFrame frame{.tick = drives.tick() + 1};
    frame.axes.push_back(plan.next_point(now(), frame.tick));
    (void)drives.take({frame});
    drives.step();
  }
};

TEST(JointPlan, GoesToAPositionInTheModeOfPositionsAndHoldsIt) {
  Planned joint;
  EXPECT_TRUE(joint.plan.go_to(joint.now(), 0.1));
  const auto first = joint.plan.next_point(joint.now(), joint.drives.tick() + 1);
  EXPECT_EQ(first.mode, OperatingMode::cyclic_synchronous_position);
  for (int tick = 0; tick < 1'000 && joint.plan.streams(); ++tick) joint.step();
  EXPECT_EQ(joint.plan.task(), JointTask::hold);
  EXPECT_EQ(joint.drives.axis(0).status.position_demand_value, 100) << "0.1 rad of 0.001 rad";
  EXPECT_EQ(joint.plan.motion(joint.now(), joint.drives.tick()).position, 0.1);
  EXPECT_FALSE(joint.plan.go_to(joint.now(), 0.1)) << "it is there";
}

TEST(JointPlan, ComesToRestBeforeItFollowsPositions) {
  Planned joint;
  joint.plan.run(joint.now(), JointTask::velocity, 1.0);
  joint.drives.axis(0).status.velocity_demand_value = 1000;
  EXPECT_TRUE(joint.plan.moves_by_itself(joint.now()));
  EXPECT_FALSE(joint.plan.go_to(joint.now(), 0.1)) << "no position is sent yet";
  EXPECT_EQ(joint.plan.task(), JointTask::settle);
  EXPECT_FALSE(joint.plan.settles(joint.now()));
  const auto mode = joint.plan.mode_point(joint.now(), joint.drives.tick() + 20);
  ASSERT_TRUE(mode);
  EXPECT_EQ(mode->mode, OperatingMode::cyclic_synchronous_position);
  EXPECT_FALSE(mode->position);
  EXPECT_FALSE(joint.plan.mode_point(joint.now(), joint.drives.tick() + 20)) << "it is on its way";
  (void)joint.drives.take({{.axes = {*mode}}});
  joint.drives.step();
  EXPECT_TRUE(joint.plan.settles(joint.now()));
  EXPECT_EQ(joint.plan.task(), JointTask::track);
}

TEST(JointPlan, SendsTheModeOfAVelocityFirstAndAgainWhereTheDriveDidNotTakeIt) {
  Planned joint;
  EXPECT_FALSE(joint.plan.run(joint.now(), JointTask::velocity, 1.5)) << "no velocity is sent yet";
  const std::uint64_t reached = joint.drives.tick() + 3;
  const auto point = joint.plan.mode_point(joint.now(), reached);
  ASSERT_TRUE(point);
  EXPECT_EQ(point->mode, OperatingMode::cyclic_synchronous_velocity);
  EXPECT_EQ(point->objects.size(), 4U) << "60C2h and the offsets 60B0h, 60B1h and 60B2h";
  EXPECT_FALSE(point->velocity) << "the drive would drop it";
  EXPECT_FALSE(joint.plan.mode_point(joint.now(), reached)) << "it is on its way";
  for (int tick = 0; tick < 4; ++tick) joint.drives.step();
  EXPECT_FALSE(joint.plan.settles(joint.now()));
  EXPECT_TRUE(joint.plan.mode_point(joint.now(), joint.drives.tick() + 3))
      << "its tick has passed, and 6061h shows another mode";
}

TEST(JointPlan, RampsToAVelocityAndKeepsIt) {
  Planned joint;
  joint.plan.run(joint.now(), JointTask::velocity, 1.0);
  joint.enter();
  const AxisStatus& shown = joint.drives.axis(0).status;
  std::int32_t last = 0;
  int ticks = 0;
  while (joint.plan.streams() && ++ticks < 1'000) {
    joint.step();
    // 50 rad/s² are 0.05 rad/s per tick, 50 units of 0.001 rad/s, plus one for two roundings.
    EXPECT_LE(shown.velocity_demand_value - last, 51);
    last = shown.velocity_demand_value;
  }
  EXPECT_EQ(last, 1'000);
  EXPECT_NEAR(ticks, 20, 1) << "1 rad/s by 0.05 rad/s a tick";
  joint.drives.step();
  EXPECT_EQ(joint.plan.check_end(joint.now()), JointPlan::End::reached);
  EXPECT_FALSE(joint.plan.run(joint.now(), JointTask::velocity, 1.0)) << "the drive has it";
  EXPECT_FALSE(joint.plan.streams());
}

// 0.1 rad/s every 10 ms are 10 rad/s²: 10 units of 0.001 rad/s per tick.
TEST(JointPlan, LeadsAStreamOfVelocitiesInAStraightLine) {
  Planned joint;
  joint.plan.run(joint.now(), JointTask::velocity, 0.1);
  joint.enter();
  const AxisStatus& shown = joint.drives.axis(0).status;
  for (int command = 2; command <= 20; ++command) {
    joint.plan.run(joint.now(), JointTask::velocity, 0.1 * command);
    for (int tick = 0; tick < 10; ++tick) {
      const std::int32_t before = shown.velocity_demand_value;
      joint.step();
      if (command > 8) {
        EXPECT_NEAR(shown.velocity_demand_value - before, 10, 1) << "rounded twice";
      }
    }
  }
}

TEST(JointPlan, ReachesAVelocityThatIsRepeated) {
  Planned joint;
  joint.plan.run(joint.now(), JointTask::velocity, 1.0);
  joint.enter();
  for (int tick = 0; tick < 30; ++tick) {
    joint.plan.run(joint.now(), JointTask::velocity, 1.0);
    if (joint.plan.streams()) joint.step();
  }
  EXPECT_EQ(joint.drives.axis(0).status.velocity_demand_value, 1'000);
  EXPECT_FALSE(joint.plan.streams()) << "its line was not begun anew";
}

TEST(JointPlan, RampsToAnEffortInThousandthsOfTheRatedTorque) {
  Planned joint;
  joint.plan.run(joint.now(), JointTask::effort, -1.5);
  joint.enter();
  EXPECT_EQ(joint.drives.axis(0).mode(), OperatingMode::cyclic_synchronous_torque);
  const AxisStatus& shown = joint.drives.axis(0).status;
  int last = 0;
  for (int tick = 0; tick < 1'000 && joint.plan.streams(); ++tick) {
    joint.step();
    // 30 N.m/s are 0.03 N.m per tick, 10 units of 0.003 N.m, plus one for two roundings.
    EXPECT_GE(shown.torque_demand - last, -11);
    last = shown.torque_demand;
  }
  EXPECT_EQ(last, -500) << "-1.5 N.m of 0.003 N.m";
}

TEST(JointPlan, BrakesWhatVelocityOrEffortMoveAndNothingElse) {
  Planned joint;
  EXPECT_FALSE(joint.plan.brake_free());
  joint.plan.run(joint.now(), JointTask::velocity, 0.0);
  EXPECT_FALSE(joint.plan.brake_free()) << "it rests";
  joint.plan.run(joint.now(), JointTask::effort, 1.0);
  EXPECT_TRUE(joint.plan.brake_free());
  EXPECT_EQ(joint.plan.task(), JointTask::velocity);
  EXPECT_TRUE(joint.plan.is_entering()) << "the drive brakes when its mode changes";
}

TEST(JointPlan, BrakesAVelocityOnItsRamp) {
  Planned joint;
  joint.plan.run(joint.now(), JointTask::velocity, 1.0);
  joint.enter();
  while (joint.plan.streams()) joint.step();
  EXPECT_TRUE(joint.plan.brake_free());
  const AxisStatus& shown = joint.drives.axis(0).status;
  joint.step();
  EXPECT_NEAR(shown.velocity_demand_value, 950, 1) << "0.05 rad/s a tick";
  while (joint.plan.streams()) joint.step();
  EXPECT_EQ(shown.velocity_demand_value, 0);
  EXPECT_FALSE(joint.plan.brake_free());
}

TEST(JointPlan, BrakesOnceWithoutACommandInTime) {
  Planned joint;
  joint.plan.run(joint.now(), JointTask::velocity, 1.0);
  for (int tick = 0; tick < 100; ++tick) joint.drives.step();
  EXPECT_FALSE(joint.plan.brake_without_command(joint.now(), 0.1)) << "0.1 s are not over";
  joint.drives.step();
  EXPECT_TRUE(joint.plan.brake_without_command(joint.now(), 0.1));
  EXPECT_FALSE(joint.plan.brake_without_command(joint.now(), 0.1));
  joint.enter();
  EXPECT_EQ(joint.plan.next_point(joint.now(), joint.drives.tick() + 1).velocity, 0);
}

TEST(JointPlan, GetsALastVelocityAgainThatTheDriveDoesNotFollow) {
  Planned joint;
  joint.plan.run(joint.now(), JointTask::velocity, 1.0);
  joint.enter();
  for (int repeat = 0; repeat <= 8; ++repeat) {
    while (joint.plan.streams()) {
      (void)joint.plan.next_point(joint.now(), joint.drives.tick() + 1);  // lost
      joint.drives.step();
    }
    EXPECT_EQ(joint.plan.check_end(joint.now()), JointPlan::End::open) << "its tick is now";
    joint.drives.step();
    const JointPlan::End expected = repeat < 8 ? JointPlan::End::refused : JointPlan::End::given_up;
    ASSERT_EQ(joint.plan.check_end(joint.now()), expected) << repeat;
    if (expected == JointPlan::End::refused) joint.plan.repeat_end(joint.now());
  }
  EXPECT_TRUE(joint.plan.run(joint.now(), JointTask::velocity, 1.0)) << "a command is tried again";
}

TEST(JointPlan, WritesAVelocityThatTheDriveHoldsBackOnlyWithACommand) {
  Planned joint;
  joint.plan.run(joint.now(), JointTask::velocity, 1.0);
  joint.enter();
  while (joint.plan.streams()) joint.step();
  joint.drives.axis(0).status.velocity_demand_value = 0;
  joint.drives.show(0, PowerState::operation_enabled);  // bit 12 is 0: limit switch or halt
  joint.drives.step();
  EXPECT_EQ(joint.plan.check_end(joint.now()), JointPlan::End::open);
  EXPECT_FALSE(joint.plan.streams());
  EXPECT_TRUE(joint.plan.run(joint.now(), JointTask::velocity, 1.0));
  EXPECT_TRUE(joint.plan.streams());
}

// The bench has overtaken the set-points and holds the velocity of the last one.
TEST(JointPlan, LeadsOnFromTheVelocityThatTheDriveHolds) {
  Planned joint;
  joint.plan.run(joint.now(), JointTask::velocity, 1.0);
  joint.enter();
  for (int tick = 0; tick < 10; ++tick) joint.step();
  const std::int32_t held = joint.drives.axis(0).status.velocity_demand_value;
  joint.drives.count_from(joint.drives.tick() + 50);
  EXPECT_EQ(joint.plan.start_again(joint.now()), 0U) << "it follows no trajectory";
  joint.step();
  EXPECT_NEAR(joint.drives.axis(0).status.velocity_demand_value, held + 50, 1)
      << "0.05 rad/s a tick";
}

// The received state may be older than a mode command still in transit.
TEST(JointPlan, WaitsForAModeThatIsShownAlreadyUntilItWasReached) {
  Planned joint;
  joint.drives.axis(0).status.op_mode_actual =
      static_cast<std::int8_t>(OperatingMode::cyclic_synchronous_velocity);
  joint.plan.run(joint.now(), JointTask::velocity, 1.0);
  EXPECT_FALSE(joint.plan.settles(joint.now())) << "it was not sent";
  EXPECT_TRUE(joint.plan.mode_point(joint.now(), joint.drives.tick() + 2));
  joint.drives.step();
  EXPECT_FALSE(joint.plan.settles(joint.now()));
  joint.drives.step();
  EXPECT_TRUE(joint.plan.settles(joint.now()));
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
  for (int tick = 0; tick < 1'000 && joint.plan.streams(); ++tick) joint.step();
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
  EXPECT_EQ(joint.plan.task(), JointTask::hold);
  EXPECT_EQ(joint.plan.motion(joint.now(), 0).position, 0.5);
}

TEST(JointPlan, GetsItsLastSetPointAgainUpToEightTimes) {
  Planned joint;
  EXPECT_TRUE(joint.plan.go_to(joint.now(), 0.1));
  for (int repeat = 0; repeat <= 8; ++repeat) {
    while (joint.plan.streams()) {
      (void)joint.plan.next_point(joint.now(), joint.drives.tick() + 1);  // lost
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
  while (joint.plan.streams()) joint.step();
  joint.drives.step();
  EXPECT_EQ(joint.plan.check_end(joint.now()), JointPlan::End::reached);
}

}  // namespace
}  // namespace vdrive::ros2
