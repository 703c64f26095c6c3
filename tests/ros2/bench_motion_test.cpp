// SPDX-License-Identifier: Apache-2.0
#include "bench_motion.hpp"

#include "fake_benches.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::ros2 {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// A bench whose joints x and y are enabled.
struct Commanded : FakeBenches {
  explicit Commanded(Settings with = {}) : FakeBenches(std::move(with)) {
    add(1, {"x", "y"});
    enable();
    (void)drive().take_sent();
    written.lines.clear();
  }

  FakeBench& drive() { return drives.at(1); }

  void command(std::size_t place, CommandInterface interface, double value) {
    motion().command(
        {.joint = {.bench = 1, .place = place}, .interface = interface, .value = value});
    turn();
  }

  /// Follows a trajectory to 1 rad within 1 s.
  void follow(std::size_t place, std::uint64_t number) {
    const std::vector<PathPoint> points{{.time = 1.0, .position = 1.0}};
    motion().follow(place, std::make_shared<const JointPath>(JointMotion{}, points),
                    motion().begin_tick(), number);
  }

  std::int32_t demand(std::size_t place) {
    return drive().axis(place).status.position_demand_value;
  }
};

/// @return the frames that contain set-points; the others only keep the bench alive.
std::vector<client::SetPointFrame> with_axes(std::vector<client::SetPointFrame> frames) {
  std::erase_if(frames, [](const client::SetPointFrame& frame) {
    return frame.axes.empty();
  });
  return frames;
}

TEST(BenchMotion, SendsEachTickOnceAndAheadOfTheBench) {
  Commanded fake;
  fake.command(0, CommandInterface::position, 1.0);
  const auto frames = with_axes(fake.drive().take_sent());
  // In lock-step the first set-point is 20 ticks ahead, and set-points are sent for up to 40 ticks
  // ahead while a step lasts.
  ASSERT_THAT(frames, SizeIs(21));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].tick, FakeBench::kBegin + 20 + i);
  }
  fake.run(1);
  EXPECT_THAT(with_axes(fake.drive().take_sent()),
              ElementsAre(Field(&client::SetPointFrame::tick, FakeBench::kBegin + 41)));
}

TEST(BenchMotion, MovesTwoJointsInTheSameFrames) {
  Commanded fake;
  fake.command(0, CommandInterface::position, 0.5);
  (void)fake.drive().take_sent();
  fake.command(1, CommandInterface::position, -0.5);
  fake.run(100);
  EXPECT_THAT(with_axes(fake.drive().take_sent()),
              Each(Field(&client::SetPointFrame::axes, SizeIs(2))));
  fake.run(400);
  EXPECT_EQ(fake.demand(0), 500) << "0.5 rad of 0.001 rad";
  EXPECT_EQ(fake.demand(1), -500);
  EXPECT_FALSE(fake.motion().is_busy());
}

TEST(BenchMotion, SendsAVelocityAfterThePositionsThatAreOnTheirWay) {
  Commanded fake;
  fake.command(0, CommandInterface::position, 1.0);
  (void)fake.drive().take_sent();
  fake.command(0, CommandInterface::velocity, 0.5);
  const auto frames = with_axes(fake.drive().take_sent());
  ASSERT_THAT(frames, SizeIs(1));
  EXPECT_EQ(frames[0].tick, FakeBench::kBegin + 41) << "positions are sent up to 40 ticks ahead";
  EXPECT_EQ(frames[0].axes[0].mode, OperatingMode::cyclic_synchronous_velocity);
  EXPECT_FALSE(frames[0].axes[0].velocity) << "it waits for its mode";
  fake.run(100);
  EXPECT_EQ(fake.drive().axis(0).status.velocity_demand_value, 500);
}

TEST(BenchMotion, ChangesTheModeOfAJointThatMoves) {
  Commanded fake;
  const client::AxisSnapshot& axis = fake.drive().axis(0);
  fake.command(0, CommandInterface::velocity, 1.0);
  fake.run(100);
  EXPECT_EQ(axis.status.velocity_demand_value, 1'000);
  fake.command(0, CommandInterface::effort, 1.5);
  fake.run(150);
  EXPECT_EQ(axis.mode(), OperatingMode::cyclic_synchronous_torque);
  EXPECT_EQ(axis.status.torque_demand, 500) << "1.5 N.m of 0.003 N.m";
  fake.command(0, CommandInterface::position, 0.5);
  fake.run(600);
  EXPECT_EQ(axis.mode(), OperatingMode::cyclic_synchronous_position);
  EXPECT_EQ(fake.demand(0), 500) << "0.5 rad of 0.001 rad";
  EXPECT_FALSE(fake.motion().is_busy());
}

TEST(BenchMotion, IgnoresACommandThatItCannotCarryOutAndReportsIt) {
  Commanded fake;
  fake.command(0, CommandInterface::velocity, 6.0);
  fake.drive().axis(1).owner_session = 0x0B;
  fake.turn();
  fake.command(1, CommandInterface::position, 0.1);
  EXPECT_THAT(with_axes(fake.drive().take_sent()), IsEmpty());
  EXPECT_THAT(fake.written.lines,
              ElementsAre("joint x: velocity 6 is above the limit 5: the command is ignored",
                          "joint y: is controlled by an unknown program, session "
                          "0x000000000000000b: the command is ignored"));
}

TEST(BenchMotion, EndsAllPlansWhenOneOfTheirAxesFailsAndBrakesWhatRunsFreely) {
  Commanded fake;
  fake.command(0, CommandInterface::position, 1.0);
  fake.command(1, CommandInterface::velocity, 1.0);
  fake.run(150);
  EXPECT_EQ(fake.drive().axis(1).status.velocity_demand_value, 1'000);
  fake.drive().show(0, PowerState::fault);
  fake.turn();
  EXPECT_THAT(fake.motion().tasks(), ElementsAre(JointTask::none, JointTask::velocity));
  EXPECT_THAT(fake.written.lines,
              Contains(AllOf(HasSubstr("joint y: joint x "), HasSubstr(": it brakes"))));
  fake.run(100);
  EXPECT_EQ(fake.drive().axis(1).status.velocity_demand_value, 0);
}

TEST(BenchMotion, GoesOnWhereTheBenchHoldsAndKeepsALargerDistance) {
  Settings settings;
  FakeBenches fake(settings);
  fake.add(1, {"x"});
  fake.drives.at(1).info().clock_mode = ClockMode::realtime;
  fake.enable();
  fake.motion().command({.joint = {.bench = 1}, .value = 1.0});
  fake.turn();
  fake.run(50);
  fake.drives.at(1).count_from(fake.drives.at(1).tick() + 100);
  (void)fake.drives.at(1).take_sent();
  fake.turn();
  const auto frames = with_axes(fake.drives.at(1).take_sent());
  ASSERT_FALSE(frames.empty());
  // The lead of 8 ms is 8 ticks; set-points that were late have doubled it.
  EXPECT_EQ(frames.front().tick, fake.drives.at(1).tick() + 16);
  fake.run(1'000);
  EXPECT_EQ(fake.drives.at(1).axis(0).status.position_demand_value, 1'000);
}

TEST(BenchMotion, BrakesAJointThatGetsNoCommandInTime) {
  Settings settings;
  settings.command_timeout = 0.05;
  Commanded fake(settings);
  fake.command(1, CommandInterface::velocity, 1.0);
  fake.run(50);
  EXPECT_THAT(fake.written.lines, IsEmpty());
  EXPECT_EQ(fake.drive().axis(1).status.velocity_demand_value, 1'000);
  fake.run(1);
  EXPECT_THAT(fake.written.lines, ElementsAre("joint y: no command for 0.05 s: it brakes"));
  EXPECT_EQ(with_axes(fake.drive().take_sent()).back().axes[0].velocity, 0);
}

TEST(BenchMotion, ReportsWhatABenchDoesNotTake) {
  WrittenReports written;
  FakeBench drives({"x"});
  Bench bench(drives.info(), drives.joints());
  BenchMotion motion(FakeBench::kSession, bench, written.reports, 0.0, [](const auto&) {
    return client::Outcome::failed("the bench is away");
  });
  drives.enable();
  motion.power().want_enabled(true, false);
  drives.link(bench);
  (void)motion.update({});
  EXPECT_THAT(written.lines, ElementsAre("bench 1: the bench is away")) << "the keep-alive";
}

// Habit e of docs/guides/be-another-drive.md. Here enabling has already written the mode.
TEST(BenchMotion, FollowsPositionsWhereADriveRefusesAnotherModeAndWaitsForOne) {
  Commanded fake;
  fake.drive().axis(0).status.op_mode_actual =
      static_cast<std::int8_t>(OperatingMode::cyclic_synchronous_position);
  fake.drive().keep_modes();
  fake.command(0, CommandInterface::position, 0.1);
  fake.run(300);
  EXPECT_EQ(fake.demand(0), 100) << "0.1 rad of 0.001 rad";
  (void)fake.drive().take_sent();
  fake.command(0, CommandInterface::velocity, 1.0);
  fake.run(200);
  const auto frames = with_axes(fake.drive().take_sent());
  EXPECT_FALSE(frames.empty());
  for (const client::SetPointFrame& frame : frames) {
    EXPECT_EQ(frame.axes.front().mode, OperatingMode::cyclic_synchronous_velocity);
    EXPECT_FALSE(frame.axes.front().velocity);
  }
  EXPECT_EQ(fake.demand(0), 100);
  fake.command(0, CommandInterface::position, 0.2);
  fake.run(300);
  EXPECT_EQ(fake.demand(0), 200);
}

// Habit h: 6061h follows 6060h late. At 50 rad/s² it takes 20 ms to reach 1 rad/s.
TEST(BenchMotion, WaitsForAModeThatADriveShowsLate) {
  Commanded fake;
  fake.drive().delay_modes(100);
  fake.command(0, CommandInterface::velocity, 1.0);
  fake.run(100);
  const auto frames = with_axes(fake.drive().take_sent());
  EXPECT_FALSE(frames.empty());
  for (const client::SetPointFrame& frame : frames) {
    EXPECT_FALSE(frame.axes.front().velocity);
  }
  fake.run(150);
  EXPECT_EQ(fake.drive().axis(0).status.velocity_demand_value, 1'000);
  EXPECT_THAT(fake.written.lines, IsEmpty());
}

// Habit b of docs/guides/be-another-drive.md: bits 4 to 6 of 6040h release the stream.
TEST(BenchMotion, ReportsADriveThatHoldsItsStreamAndWritesNoWordToIt) {
  Commanded fake;
  fake.drive().hold_streams();
  fake.command(0, CommandInterface::position, 0.1);
  for (int tick = 0; tick < 5'000 && fake.written.lines.empty(); ++tick) fake.run(1);
  EXPECT_THAT(fake.written.lines,
              ElementsAre("joint x: the drive does not accept its last set-point"));
  EXPECT_EQ(fake.demand(0), 0);
  const auto frames = with_axes(fake.drive().take_sent());
  EXPECT_FALSE(frames.empty());
  for (const client::SetPointFrame& frame : frames) {
    EXPECT_FALSE(frame.axes.front().controlword);
  }
}

TEST(BenchMotion, BrakesWhatRunsFreelyWhenNobodyCommandsAnyMore) {
  Commanded fake;
  fake.command(0, CommandInterface::velocity, 1.0);
  fake.command(1, CommandInterface::position, 0.5);
  fake.motion().stop_free_joints("the last publisher of joint commands is gone");
  EXPECT_THAT(fake.written.lines,
              ElementsAre("joint x: the last publisher of joint commands is gone: it brakes"));
  EXPECT_THAT(fake.motion().tasks(), ElementsAre(JointTask::velocity, JointTask::track));
}

TEST(BenchMotion, EndsItsPlansWhenTheBenchCountsFromALowerNumber) {
  Commanded fake;
  fake.command(0, CommandInterface::position, 1.0);
  fake.drive().count_from(FakeBench::kBegin - 500);
  fake.turn();
  EXPECT_THAT(fake.motion().tasks(), Each(JointTask::none));
  fake.command(0, CommandInterface::position, 1.0);
  EXPECT_EQ(with_axes(fake.drive().take_sent()).back().tick, FakeBench::kBegin - 460);
}

TEST(BenchMotion, EndsItsPlansWhenTheBenchSendsNoStatus) {
  Commanded fake;
  fake.follow(0, 3);
  fake.command(1, CommandInterface::velocity, 1.0);
  fake.motion().bench().set_state(nullptr);
  EXPECT_THAT(fake.motion().update(fake.time),
              ElementsAre(AllOf(Field(&BrokenTrajectory::number, std::uint64_t{3}),
                                Field(&BrokenTrajectory::reason, "bench 1 sends no status"))));
  EXPECT_EQ(fake.motion().state(), nullptr);
  EXPECT_THAT(fake.motion().tasks(), Each(JointTask::none));
  fake.command(0, CommandInterface::position, 1.0);
  EXPECT_THAT(fake.written.lines, Contains(HasSubstr("is on a bench that sends no status")));
}

TEST(BenchMotion, LeavesPlansAloneWhileAllIsWell) {
  Commanded fake;
  fake.follow(0, 3);
  fake.run(1);
  EXPECT_THAT(fake.motion().update(fake.time), IsEmpty());
  EXPECT_EQ(fake.motion().trajectory_of(0), 3U);
  EXPECT_THAT(fake.written.lines, IsEmpty());
}

TEST(BenchMotion, EndsATrajectoryThatTheBenchHasOvertakenAndKeepsALargerDistance) {
  Commanded fake;
  fake.follow(0, 3);
  fake.follow(1, 3);
  fake.turn();  // sends up to tick 1,100
  fake.drive().count_from(1'101);
  fake.drive().link(fake.motion().bench());
  const auto broken = fake.motion().update(fake.time);
  ASSERT_THAT(broken, SizeIs(2)) << "one a joint";
  EXPECT_EQ(broken[0].reason, "bench 1 was 1 ticks ahead of its set-points");
  EXPECT_THAT(fake.motion().tasks(), Each(JointTask::hold));
  EXPECT_EQ(fake.motion().begin_tick(), 1'120U) << "20 ticks ahead";
}

// ---- reasons for refusing a command

std::string problem_with(CommandInterface interface, double value,
                         const JointLimits& limits = FakeBench::limits()) {
  return problem_of({.joint = {}, .interface = interface, .value = value},
                    FakeBench({"x"}).joints()[0], limits);
}

TEST(MotionCheck, NamesWhatKeepsTheBridgeFromAnAxis) {
  FakeBench bench({"x"});
  Bench::Names names;
  const auto obstacle = [&](bool has_limits = true) {
    return obstacle_of(bench.axis(0), FakeBench::kSession, has_limits, &names);
  };
  EXPECT_EQ(obstacle(), "is not under control of this bridge yet");
  bench.axis(0).owner_session = 0x0B;
  EXPECT_EQ(obstacle(), "is controlled by an unknown program, session 0x000000000000000b");
  names[0x0B] = {.program = "vdrive", .process = 4711, .host = "bench-host"};
  EXPECT_EQ(obstacle(),
            "is controlled by vdrive (process 4711 on bench-host), session 0x000000000000000b");
  bench.axis(0).owner_session = FakeBench::kSession;
  EXPECT_EQ(obstacle(false), "has limits that have not been read yet");
  EXPECT_THAT(obstacle(), HasSubstr("Switch on disabled"));
  bench.enable();
  EXPECT_THAT(obstacle(), IsEmpty());
}

TEST(MotionCheck, PermitsAValueAtItsLimitAndNoneBeyond) {
  EXPECT_THAT(problem_with(CommandInterface::position, 10.0), IsEmpty());
  EXPECT_EQ(problem_with(CommandInterface::position, 10.5),
            "position 10.5 rad is beyond the limits -10 to 10");
  EXPECT_EQ(problem_with(CommandInterface::position, -10.5),
            "position -10.5 rad is beyond the limits -10 to 10");
  EXPECT_THAT(problem_with(CommandInterface::velocity, -5.0), IsEmpty());
  EXPECT_EQ(problem_with(CommandInterface::velocity, -5.5), "velocity -5.5 is above the limit 5");
  EXPECT_THAT(problem_with(CommandInterface::effort, 3.0), IsEmpty());
  EXPECT_EQ(problem_with(CommandInterface::effort, 3.5), "effort 3.5 is above the limit 3");
}

TEST(MotionCheck, RefusesAPositionThatNoSpeedOrRampReaches) {
  JointLimits still = FakeBench::limits();
  still.ramp = 0.0;
  EXPECT_THAT(problem_with(CommandInterface::position, 1.0, still),
              HasSubstr("speed limit or ramp is 0"));
  still = FakeBench::limits();
  still.velocity = 0.0;
  EXPECT_THAT(problem_with(CommandInterface::position, 1.0, still),
              HasSubstr("speed limit or ramp is 0"));
}

}  // namespace
}  // namespace vdrive::ros2
