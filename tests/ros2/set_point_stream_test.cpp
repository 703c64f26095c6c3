// SPDX-License-Identifier: Apache-2.0
#include "set_point_stream.hpp"

#include "fake_bench.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::ros2 {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

/// The set-points of a bench in lock-step with joints x and y at rest.
struct Streamed {
  FakeBench drives{{"x", "y"}};
  Bench bench{drives.info(), drives.joints()};
  JointPlans plans{2};
  SetPointStream stream{drives.info(), 0.001, plans};

  Streamed() { drives.enable(); }

  BenchCycle now() {
    drives.link(bench);
    return {.bench = bench, .seen = bench.seen()};
  }
};

TEST(SetPointStream, BeginsAfterTheLeadOrWhereItIsWanted) {
  Streamed sut;
  sut.stream.begin(1'000);
  EXPECT_EQ(sut.stream.sent_until(), 1'019U) << "the first set-point is 20 ticks ahead";
  sut.stream.begin(1'000, 1'051);
  EXPECT_EQ(sut.stream.sent_until(), 1'019U) << "a trajectory is taken 50 ticks before its begin";
  sut.stream.begin(1'001, 1'051);
  EXPECT_EQ(sut.stream.sent_until(), 1'051U);
  sut.stream.begin(1'002);
  EXPECT_EQ(sut.stream.sent_until(), 1'051U) << "what was sent stays";
  sut.stream.clear();
  sut.stream.begin(1'002);
  EXPECT_EQ(sut.stream.sent_until(), 1'021U);
}

TEST(SetPointStream, SendsNothingForJointsThatRest) {
  Streamed sut;
  EXPECT_FALSE(sut.stream.is_running());
  EXPECT_THAT(sut.stream.points(sut.now()), IsEmpty());
  EXPECT_THAT(sut.stream.modes(sut.now()), IsEmpty());
}

TEST(SetPointStream, FillsALargerWindowForATrajectory) {
  Streamed sut;
  const std::vector<PathPoint> points{{.time = 1.0, .position = 1.0}};
  sut.stream.begin(1'000);
  sut.plans[0].follow(sut.now().joint(0), std::make_shared<const JointPath>(JointMotion{}, points),
                      sut.stream.sent_until(), 1);
  EXPECT_TRUE(sut.stream.is_running());
  EXPECT_THAT(sut.stream.points(sut.now()), SizeIs(81)) << "ticks 1,020 to 1,100";
  EXPECT_EQ(sut.stream.sent_until(), 1'100U);
}

TEST(SetPointStream, SendsVelocityAndEffortOfAllJointsInOneFrame) {
  Streamed sut;
  sut.plans[0].run(sut.now().joint(0), JointTask::velocity, 1.0);
  sut.plans[1].run(sut.now().joint(1), JointTask::effort, 1.5);
  const auto modes = sut.stream.modes(sut.now());
  ASSERT_THAT(modes, SizeIs(1));
  EXPECT_EQ(modes[0].tick, 0U) << "at once: no set-point is on its way";
  ASSERT_THAT(modes[0].axes, SizeIs(2));
  EXPECT_EQ(modes[0].axes[0].mode, OperatingMode::cyclic_synchronous_velocity);
  EXPECT_EQ(modes[0].axes[1].mode, OperatingMode::cyclic_synchronous_torque);
  EXPECT_THAT(sut.stream.points(sut.now()), IsEmpty()) << "the drives are not in them yet";
  (void)sut.drives.take(modes);
  sut.drives.step();
  EXPECT_THAT(sut.stream.modes(sut.now()), IsEmpty());
  const auto frames = sut.stream.points(sut.now());
  ASSERT_THAT(frames, SizeIs(21)) << "ticks 1,021 to 1,041";
  EXPECT_EQ(frames[0].tick, 1'021U);
  ASSERT_THAT(frames[0].axes, SizeIs(2));
  EXPECT_EQ(frames[0].axes[0].velocity, 50) << "50 rad/s² for a tick";
  EXPECT_EQ(frames[0].axes[1].torque, 10) << "30 N.m/s for a tick";
}

TEST(SetPointStream, BeginsWithPositionsOnceAJointHasComeToRest) {
  Streamed sut;
  sut.drives.axis(0).status.velocity_demand_value = 100;
  EXPECT_FALSE(sut.plans[0].go_to(sut.now().joint(0), 0.5));
  EXPECT_THAT(sut.stream.modes(sut.now()), SizeIs(1)) << "the mode of positions";
  EXPECT_THAT(sut.stream.points(sut.now()), IsEmpty());
  sut.drives.axis(0).status.velocity_demand_value = 0;
  sut.drives.axis(0).status.op_mode_actual =
      static_cast<std::int8_t>(OperatingMode::cyclic_synchronous_position);
  EXPECT_THAT(sut.stream.modes(sut.now()), IsEmpty());
  EXPECT_THAT(sut.stream.points(sut.now()), SizeIs(21)) << "ticks 1,020 to 1,040";
}

// ---- lead over the bench

TEST(SetPointLead, IsWallTimeInTicksOfTheBench) {
  SetPointLead lead(ClockMode::realtime, 0.001);
  EXPECT_EQ(lead.lead(), 8U);
  EXPECT_EQ(lead.window(false), 16U) << "twice the lead is longer than 15 ms";
  EXPECT_EQ(lead.window(true), 150U);
  lead.set_rate(2.0);
  EXPECT_EQ(lead.lead(), 16U);
  EXPECT_EQ(lead.window(true), 300U);
}

TEST(SetPointLead, IsAtLeastATickAndAtMostWhatABenchKeeps) {
  SetPointLead slow(ClockMode::realtime, 0.01);
  slow.set_rate(0.1);
  EXPECT_EQ(slow.lead(), 1U);
  SetPointLead fast(ClockMode::realtime, 0.000125);
  fast.set_rate(10.0);
  EXPECT_EQ(fast.window(true), 400U);
}

TEST(SetPointLead, DoublesAfterSetPointsThatCameTooLateUpToALimit) {
  SetPointLead lead(ClockMode::realtime, 0.001);
  lead.lengthen();
  EXPECT_EQ(lead.lead(), 16U);
  for (int i = 0; i < 10; ++i) lead.lengthen();
  EXPECT_EQ(lead.lead(), 128U);
  EXPECT_EQ(lead.window(false), 256U) << "a window shorter than the lead would send nothing";
}

TEST(SetPointLead, IsCountedInTicksInLockStep) {
  SetPointLead lead(ClockMode::lockstep, 0.001);
  lead.set_rate(50.0);
  lead.lengthen();
  EXPECT_EQ(lead.lead(), 20U);
  EXPECT_EQ(lead.window(false), 40U);
  EXPECT_EQ(lead.window(true), 100U);
  EXPECT_EQ(lead.ahead_of_trajectory(), 50U);
}

}  // namespace
}  // namespace vdrive::ros2
