// SPDX-License-Identifier: Apache-2.0
#include "trajectories.hpp"

#include "fake_benches.hpp"
#include "ros_time.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace vdrive::ros2 {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// Two benches with their joints enabled: x and y, and z. The log is empty.
struct Moved : FakeBenches {
  Moved() {
    add(1, {"x", "y"});
    add(2, {"z"});
    enable();
    written.lines.clear();
  }

  /// Sends a trajectory to `positions` that arrives `arrival` seconds after its stamp.
  void send(std::vector<std::string> names, std::vector<double> positions, double arrival = 1.0,
            std::int64_t stamp = 0) {
    ros::JointTrajectory message;
    message.header.stamp = ros_time(stamp);
    message.joint_names = std::move(names);
    ros::JointTrajectoryPoint point;
    point.time_from_start.sec = static_cast<std::int32_t>(arrival);
    point.positions = std::move(positions);
    message.points = {point};
    trajectories.take(message, {});
    turn();
  }

  std::int32_t demand(std::uint32_t bench, std::size_t place) {
    return drives.at(bench).axis(place).status.position_demand_value;
  }

  /// @return a stamp this long after the current tick of bench 1 [ns].
  std::int64_t stamp_in(std::int64_t milliseconds) {
    return (static_cast<std::int64_t>(drives.at(1).tick()) + milliseconds) * 1'000'000;
  }
};

TEST(Trajectories, MoveTheirJointsAndAreReportedAtBeginAndEnd) {
  Moved fake;
  fake.send({"y", "x"}, {0.2, 0.1});
  EXPECT_THAT(fake.written.lines,
              ElementsAre("joint trajectory: number 1 of y, x, 1 points: starts"));
  fake.run(1'100);
  EXPECT_EQ(fake.demand(1, 0), 100) << "0.1 rad of 0.001 rad";
  EXPECT_EQ(fake.demand(1, 1), 200);
  EXPECT_THAT(fake.written.lines,
              Contains(HasSubstr("number 1 of y, x, 1 points: set-points sent")));
}

TEST(Trajectories, AreRefusedWithTheReason) {
  Moved fake;
  fake.send({"x"}, {11.0}, 10.0);
  fake.send({"a"}, {0.1});
  fake.drives.at(1).show(1, PowerState::fault);
  fake.send({"x", "y"}, {0.1, 0.1});
  EXPECT_THAT(fake.written.lines,
              ElementsAre(HasSubstr("refused: joint x: position 11 rad"),
                          HasSubstr("refused: joint 'a' is unknown"), HasSubstr("joint y: shows"),
                          HasSubstr("refused: joint y shows")));
  EXPECT_FALSE(fake.motion().is_busy()) << "x does not move alone";
}

TEST(Trajectories, ThatBeginElsewhereAreRefused) {
  Moved fake;
  fake.send({"x"}, {0.5}, 0.0);
  EXPECT_THAT(fake.written.lines,
              ElementsAre(HasSubstr("joint x is at 0, its point at the start is 0.5 rad: more than "
                                    "the start_tolerance of 0.01 away")));
}

TEST(Trajectories, WaitForTheirTime) {
  Moved fake;
  fake.send({"x"}, {0.1}, 1.0, fake.stamp_in(200));
  fake.run(100);
  EXPECT_THAT(fake.written.lines, IsEmpty());
  // The trajectory starts at its stamp, 200 ticks after the message, and arrives 1,000 ticks later.
  // One tick before the arrival, the 0.1 UU that are left are rounded away.
  fake.run(1'099);
  EXPECT_EQ(fake.demand(1, 0), 100);
  EXPECT_THAT(fake.written.lines, Contains(HasSubstr("number 1 of x, 1 points: starts")));
}

TEST(Trajectories, ThatWaitAreReplacedByANewerOne) {
  Moved fake;
  fake.send({"x"}, {0.1}, 1.0, fake.stamp_in(1'000));
  fake.send({"y"}, {0.2}, 1.0, fake.stamp_in(1'001));
  fake.run(2'200);
  EXPECT_EQ(fake.demand(1, 0), 0);
  EXPECT_EQ(fake.demand(1, 1), 200);
}

TEST(Trajectories, ThatWaitDoNotStartAfterTheAxesWereDisabled) {
  Moved fake;
  fake.send({"x"}, {0.1}, 1.0, fake.stamp_in(200));
  fake.trajectories.note_enable(false);
  fake.run(1'300);
  EXPECT_EQ(fake.demand(1, 0), 0);
}

TEST(Trajectories, WhoseJointWentToAnotherBenchWhileTheyWaitedAreRefused) {
  Moved fake;
  fake.send({"z"}, {0.1}, 1.0, fake.stamp_in(1'000));
  fake.drives.erase(2);
  for (int second = 0; second < 61; ++second) fake.find();  // bench 2 is dropped after a minute
  fake.add(3, {"z"});
  fake.find();
  fake.turn();
  EXPECT_THAT(fake.written.lines, Contains(HasSubstr("refused: joint z is no longer present")));
}

TEST(Trajectories, ReplaceOneUnderWayAndBrakeTheJointsThatTheyDoNotMove) {
  Moved fake;
  fake.send({"x", "y"}, {1.0, 1.0});
  fake.run(300);
  fake.send({"x"}, {0.0});
  EXPECT_EQ(fake.motion().trajectory_of(0), 2U);
  EXPECT_EQ(fake.motion().trajectory_of(1), 0U);
  fake.run(1'200);
  EXPECT_EQ(fake.demand(1, 0), 0);
  // The first trajectory began after tick 19 and was sent up to tick 400, where y is at 0.381 rad.
  // From there it brakes from 1 rad/s at 50 rad/s² within 0.01 rad.
  EXPECT_NEAR(fake.demand(1, 1), 391, 1);
  EXPECT_FALSE(fake.motion().is_busy());
}

TEST(Trajectories, EndOnAllBenchesWhenAnAxisFailsOnOne) {
  Moved fake;
  fake.send({"x", "z"}, {1.0, 1.0});
  fake.run(300);
  fake.drives.at(1).show(0, PowerState::fault);
  fake.run(200);
  EXPECT_THAT(fake.written.lines,
              Contains(HasSubstr("number 1 of x, z, 1 points: stopped, joint x shows")));
  EXPECT_FALSE(fake.motion(2).is_busy());
  EXPECT_LT(fake.demand(2, 0), 500) << "z has braked long before its point";
}

TEST(Trajectories, EndWhenTheBenchHasOvertakenThem) {
  Moved fake;
  fake.send({"x"}, {1.0});
  fake.run(100);
  fake.drives.at(1).count_from(fake.drives.at(1).tick() + 200);
  fake.turn();
  // By tick 100, set-points had been sent up to tick 200; now it is tick 300.
  EXPECT_THAT(fake.written.lines, Contains(HasSubstr("stopped, bench 1 was 100 ticks ahead of its "
                                                     "set-points")));
  EXPECT_THAT(fake.written.lines, Not(Contains(HasSubstr("set-points sent"))));
}

TEST(Trajectories, EndWithARestartOfTheirBench) {
  Moved fake;
  fake.send({"x", "z"}, {1.0, 1.0});
  fake.run(100);
  fake.drives.at(2).info().incarnation = 17;
  fake.find();
  EXPECT_THAT(fake.written.lines, Contains(HasSubstr("stopped, bench 2 was restarted")));
  fake.run(300);
  EXPECT_FALSE(fake.motion(1).is_busy()) << "x has braked";
}

}  // namespace
}  // namespace vdrive::ros2
