// SPDX-License-Identifier: Apache-2.0
#include "plan_watch.hpp"

#include "fake_bench.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::ros2 {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::Field;
using testing::IsEmpty;
using testing::Property;
using testing::SizeIs;

/// The plans of a bench in lock-step whose joints x and y rest at 0, and those who watch them.
struct Watched {
  FakeBench drives{{"x", "y"}};
  Bench bench{drives.info(), drives.joints()};
  WrittenReports written{};
  JointPlans plans{2};
  SetPointStream stream{drives.info(), 0.001, plans};
  PlanWatch watch{plans, stream, written.reports, 0.1};

  Watched() { drives.enable(); }

  BenchNow now() {
    drives.link(bench);
    return {.bench = bench, .seen = bench.seen()};
  }

  void follow(std::size_t place, std::uint64_t number) {
    const std::vector<PathPoint> points{{.time = 1.0, .position = 1.0}};
    stream.begin(drives.tick());
    plans[place].follow(now().joint(place),
                        std::make_shared<const JointPath>(JointMotion{}, points),
                        stream.sent_until(), number);
  }
};

TEST(PlanWatch, EndsAllPlansOfABenchThatIsLost) {
  Watched sut;
  sut.follow(0, 3);
  sut.plans[1].run(sut.now().joint(1), Duty::velocity, 1.0);
  EXPECT_THAT(sut.watch.drop("it is lost"),
              ElementsAre(Field(&BrokenTrajectory::number, std::uint64_t{3})));
  EXPECT_THAT(sut.plans, Each(Property(&JointPlan::duty, Duty::none)));
  EXPECT_EQ(sut.stream.sent_until(), 0U);
}

TEST(PlanWatch, LeavesPlansAloneWhileAllIsWell) {
  Watched sut;
  sut.follow(0, 3);
  (void)sut.stream.points(sut.now());
  EXPECT_THAT(sut.watch.check(sut.now()), IsEmpty());
  EXPECT_EQ(sut.plans[0].trajectory(), 3U);
  EXPECT_THAT(sut.written.lines, IsEmpty());
}

TEST(PlanWatch, EndsATrajectoryThatTheBenchHasOvertakenAndKeepsALargerDistance) {
  Watched sut;
  sut.follow(0, 3);
  sut.follow(1, 3);
  (void)sut.stream.points(sut.now());  // up to tick 1,100
  sut.drives.count_from(1'101);
  const auto broken = sut.watch.check(sut.now());
  ASSERT_THAT(broken, SizeIs(2)) << "one a joint";
  EXPECT_EQ(broken[0].reason, "bench 1 was 1 ticks ahead of its set-points");
  EXPECT_THAT(sut.plans, Each(Property(&JointPlan::duty, Duty::hold)));
  EXPECT_EQ(sut.stream.sent_until(), 1'120U) << "20 ticks ahead";
}

TEST(PlanWatch, RepeatsTheEndOfAMotionThatTheDriveDidNotTakeAndThenReportsIt) {
  Watched sut;
  EXPECT_TRUE(sut.plans[0].go_to(sut.now().joint(0), 0.1));
  sut.stream.begin(sut.drives.tick());
  for (int tick = 0; tick < 2'000 && sut.written.lines.empty(); ++tick) {
    (void)sut.stream.points(sut.now());  // lost on the way
    sut.drives.step();
    EXPECT_THAT(sut.watch.check(sut.now()), IsEmpty());
  }
  EXPECT_THAT(sut.written.lines,
              ElementsAre("joint x: the drive does not take its last set-point"));
}

TEST(PlanWatch, NamesTheJointThatGetsNoCommand) {
  Watched sut;
  sut.plans[1].run(sut.now().joint(1), Duty::velocity, 1.0);
  sut.drives.count_from(sut.drives.tick() + 101);
  EXPECT_THAT(sut.watch.check(sut.now()), IsEmpty());
  EXPECT_THAT(sut.written.lines, ElementsAre("joint y: no command for 0.1 s: it brakes"));
}

}  // namespace
}  // namespace vdrive::ros2
