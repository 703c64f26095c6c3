// SPDX-License-Identifier: Apache-2.0
// The program vdrive-ros2 between a service and ROS nodes.
#include "client/session_options.hpp"
#include "ros2/ros_peer.hpp"
#include "support/temporary_directory.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/number_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using client::Session;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kUnit = kTurn / 4096.0;   // [rad] per user unit of the default axis
constexpr std::int64_t kTick = 1'000'000;  // [ns]
constexpr std::int64_t kSecond = 1'000'000'000;

/// A configuration file of a bench. The axes are called x and y unless `names` gives others.
class BenchFile {
 public:
  explicit BenchFile(const std::string& text) {
    std::ofstream(directory_.path() / "bench.yaml") << text;
  }

  [[nodiscard]] std::string option() const {
    return "--config " + (directory_.path() / "bench.yaml").string();
  }

 private:
  TemporaryDirectory directory_;
};

/// Steps a bench together with the bridge and its ROS peer.
class Stepper {
 public:
  Stepper(Session& session, const RosPeer& peer, std::uint32_t bench = 1, std::string joint = "x")
      : session_(session), peer_(peer), bench_(bench), joint_(std::move(joint)) {}

  /// Steps, then waits until the bridge has published the tick, by which time it has sent its
  /// set-points.
  void step(std::uint64_t ticks) {
    const auto reached = session_.step(bench_, ticks);
    ASSERT_TRUE(reached) << reached.outcome().message();
    tick_ = *reached;
    // /clock is published with the state but read reliably, so it tells whether the state was lost.
    ASSERT_TRUE(peer_.wait_for_stamp(joint_, static_cast<std::int64_t>(tick_) * kTick))
        << "tick " << tick_ << ", the clock is at tick " << peer_.clock() / kTick;
  }

  /// Steps ten ticks at a time until the condition holds.
  /// @return false after 20 s of drive time.
  template <typename Condition>
  [[nodiscard]] bool step_until(const Condition& condition) {
    for (int i = 0; i < 2'000; ++i) {
      if (condition()) return true;
      step(10);
    }
    return false;
  }

  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }

 private:
  Session& session_;
  const RosPeer& peer_;
  std::uint32_t bench_;
  std::string joint_;
  std::uint64_t tick_ = 0;
};

bool is_enabled(Session& session, const std::string& axis) {
  const auto status = session.axis(axis)->status();
  return status && status->state() == PowerState::operation_enabled;
}

/// A bench in lock-step whose axes x and y the bridge has enabled.
class LockStep {
 public:
  ~LockStep() {
    if (testing::Test::HasFailure()) std::cerr << peer_.log();
  }

  LockStep(const LockStep&) = delete;
  LockStep& operator=(const LockStep&) = delete;

  explicit LockStep(const std::string& words = "--enable")
      : service_("--clock lockstep"),
        bridge_(words),
        session_(options()),
        stepper_(session_, peer_) {
    if (!peer_.wait_for_bridge()) throw std::runtime_error("no bridge");
    if (words.find("--enable") == std::string::npos) return;
    const bool enabled = stepper_.step_until([this] {
      return is_enabled(session_, "1.1") && is_enabled(session_, "1.2");
    });
    if (!enabled) throw std::runtime_error("the axes were not enabled");
    stepper_.step(10);
  }

  [[nodiscard]] RosPeer& peer() { return peer_; }

  [[nodiscard]] Session& session() { return session_; }

  [[nodiscard]] Stepper& stepper() { return stepper_; }

  [[nodiscard]] RunningBridge& bridge() { return bridge_; }

  [[nodiscard]] client::AxisSnapshot axis(const std::string& name = "1.1") {
    return session_.axis(name)->status().value();
  }

 private:
  RunningService service_;
  RosPeer peer_;
  RunningBridge bridge_;
  Session session_;
  Stepper stepper_;
};

ros::JointTrajectoryPoint point(double time, std::vector<double> positions,
                                std::vector<double> velocities = {},
                                std::vector<double> accelerations = {}) {
  ros::JointTrajectoryPoint point;
  point.positions = std::move(positions);
  point.velocities = std::move(velocities);
  point.accelerations = std::move(accelerations);
  point.time_from_start.sec = static_cast<std::int32_t>(std::floor(time));
  point.time_from_start.nanosec =
      static_cast<std::uint32_t>(std::llround((time - std::floor(time)) * 1e9));
  return point;
}

ros::JointTrajectory trajectory(std::vector<std::string> names,
                                std::vector<ros::JointTrajectoryPoint> points,
                                std::int64_t start = 0) {
  ros::JointTrajectory message;
  message.joint_names = std::move(names);
  message.points = std::move(points);
  message.header.stamp.sec = static_cast<std::int32_t>(start / kSecond);
  message.header.stamp.nanosec = static_cast<std::uint32_t>(start % kSecond);
  return message;
}

// ---- the program -----------------------------------------------------------------------------

TEST(Ros2CommandLine, FailsWhenItsAnswerCouldNotBeWritten) {
  for (const std::string flag : {"--help", "--version", "--check"}) {
    const Finished full =
        Process("/bin/sh", {"-c", VDRIVE_ROS2 " " + flag + " > /dev/full"}).wait();
    EXPECT_EQ(full.code, 1) << flag;
    EXPECT_THAT(full.errors, HasSubstr("standard output could not be written: No space left"));
  }
}

TEST(Ros2CommandLine, PrintsItsHelpAndChecksItsConfiguration) {
  const Finished help = Process(VDRIVE_ROS2, {"--help"}).wait();
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.output, HasSubstr("--namespace"));
  EXPECT_EQ(Process(VDRIVE_ROS2, {"--nonsense"}).wait().code, 2);
  EXPECT_THAT(Process(VDRIVE_ROS2, {"--version"}).wait().output, StartsWith("vdrive-ros2 "));
  const BenchFile good("rate: 50\n");
  const BenchFile bad("enable: true\nrate: 0\n");
  const auto check = [](const BenchFile& file) {
    return Process(VDRIVE_ROS2, {"--config", file.option().substr(9), "--check"}).wait();
  };
  EXPECT_EQ(check(good).code, 0);
  const Finished refused = check(bad);
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("bench.yaml:2: rate = 0: must be from 1 to 1000 Hz"));
  EXPECT_EQ(Process(VDRIVE_ROS2, {"--config", "/nothing/here"}).wait().code, 2);
  const Finished bench = Process(VDRIVE_ROS2, {"--bench", "1e9"}).wait();
  EXPECT_EQ(bench.code, 2);
  EXPECT_THAT(bench.errors, HasSubstr("--bench: '1e9' must be a whole number from 1 to 65535"));
}

TEST(Ros2, PublishesWholeArraysInTheUnitsOfTheJoints) {
  const BenchFile file(
      "bench: {number: 1}\nclock: {mode: realtime}\naxes:\n"
      "  - {number: 1, name: arm}\n"
      "  - {number: 2, name: lift, unit: {kind: linear, name: mm, per_unit: 100}}\n");
  const RunningService service(file.option());
  RosPeer peer("/cell1");
  RunningBridge bridge("--namespace /cell1");
  ASSERT_TRUE(peer.wait_for_bridge());
  Session session(options());
  ASSERT_TRUE(session.axis("1.lift")->enable());
  ASSERT_TRUE(session.axis("1.lift")->move_to(5'000));  // 50 mm
  ASSERT_TRUE(session.axis("1.arm")->enable());
  ASSERT_TRUE(session.axis("1.arm")->move_to(1'024));  // a quarter turn
  EXPECT_TRUE(peer.wait([&] {
    return std::abs(*peer.position("lift") - 0.05) < 1e-4 &&
           std::abs(*peer.position("arm") - kTurn / 4) < 1e-2;
  })) << *peer.position("lift");
  const auto state = peer.state("arm");
  EXPECT_THAT(state->name, ElementsAre("arm", "lift"));
  EXPECT_THAT(state->position, SizeIs(2));
  EXPECT_THAT(state->velocity, SizeIs(2));
  EXPECT_THAT(state->effort, SizeIs(2));
  // In real time, drive time is the time of day.
  const auto now = std::chrono::duration_cast<std::chrono::seconds>(
      std::chrono::system_clock::now().time_since_epoch());
  EXPECT_NEAR(static_cast<double>(state->header.stamp.sec), static_cast<double>(now.count()), 20.0);
  EXPECT_EQ(peer.clock(), 0) << "the clock is for drive time only";
}

TEST(Ros2, CommandsNothingUntilItIsEnabledAndDisablesAxesAtItsEnd) {
  LockStep bench("");
  RosPeer& peer = bench.peer();
  bench.stepper().step(10);
  peer.command({"x"}, {1.0});
  ASSERT_TRUE(peer.wait_for_log("joint x: is not enabled"));
  bench.stepper().step(100);
  EXPECT_EQ(bench.axis().status.position_demand_value, 0);
  EXPECT_EQ(bench.axis().owner_session, 0U);
  peer.enable(true);
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return is_enabled(bench.session(), "1.1");
  }));
  peer.enable(false);
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().owner_session == 0;
  }));
  EXPECT_FALSE(is_enabled(bench.session(), "1.1"));
  EXPECT_EQ(bench.bridge().stop().code, 0);
}

TEST(Ros2, ShowsTheJointsToANodeThatStartsBetweenTwoSteps) {
  LockStep bench("");
  bench.stepper().step(10);
  // Everything below happens between two steps.
  const RosPeer late;
  EXPECT_TRUE(late.wait_for_stamp("x", 10 * kTick));
  EXPECT_TRUE(late.wait([&] {
    return late.clock() == 10 * kTick;
  }));
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// In real time, because there a session that ends loses its axes. A watchdog of five seconds does
// not trip on a busy machine.
TEST(Ros2Control, IsAwaitedWithOneLogLineAndTakenAfterItsOwnerEnded) {
  const BenchFile file(
      "clock: {mode: realtime}\nwatchdog: {timeout_ms: 5000}\naxes:\n"
      "  - {number: 1, name: x}\n  - {number: 2, name: y}\n");
  const RunningService service(file.option());
  Session session(options());
  RosPeer peer;
  RunningBridge first("--enable");
  ASSERT_TRUE(peer.wait_for_bridge());
  ASSERT_TRUE(peer.wait([&] {
    return is_enabled(session, "1.1") && is_enabled(session, "1.2");
  }));
  const std::uint64_t owner = session.axis("1.1")->status()->owner_session;
  RosPeer other("/second");
  RunningBridge second("--enable --namespace /second");
  ASSERT_TRUE(other.wait_for_bridge());
  const std::string name = client::owner_text(owner, session.find_name(1, owner));
  EXPECT_THAT(name, testing::StartsWith("vdrive-ros2 (process "));
  const std::string waits = "bench 1: " + name + " controls 2 of its 2 axes";
  ASSERT_TRUE(other.wait_for_log(waits)) << other.log();
  // 300 joint state messages take three seconds, in which the bridge checks 15 times.
  const std::size_t states = other.states();
  ASSERT_TRUE(other.wait([&] {
    return other.states() >= states + 300;
  }));
  EXPECT_EQ(count_of(other.log(), "controls 2 of its 2 axes"), 1U) << other.log();
  EXPECT_EQ(count_of(other.log(), "refused"), 0U) << other.log();
  EXPECT_TRUE(other.wait([&] {
    return other.diagnosis("joint x") == "1 controlled by " + name ||
           other.diagnosis("joint x") == "0 Operation enabled";
  })) << other.diagnosis("joint x");
  other.command({"x"}, {1.0});
  EXPECT_TRUE(other.wait_for_log("joint x: is controlled by " + name));
  first.kill();
  ASSERT_TRUE(other.wait_for_log("bench 1: taking control: " + name +
                                 " no longer controls its axes; 2 of 2 are in a fault"))
      << other.log();
  other.enable(true);
  EXPECT_TRUE(other.wait([&] {
    return is_enabled(session, "1.1") && is_enabled(session, "1.2");
  })) << other.log();
  EXPECT_NE(session.axis("1.1")->status()->owner_session, owner);
}

TEST(Ros2Control, IsTakenForAllAxesOrForNone) {
  const RunningService service("--clock lockstep");
  Session session(options());
  RosPeer peer;
  ASSERT_TRUE(session.axis("1.2")->acquire());
  RunningBridge bridge("--enable");
  ASSERT_TRUE(peer.wait_for_bridge());
  ASSERT_TRUE(peer.wait_for_log("controls 1 of its 2 axes"));
  EXPECT_EQ(session.axis("1.1")->status()->owner_session, 0U);
  ASSERT_TRUE(session.release(1));
  Stepper stepper(session, peer);
  EXPECT_TRUE(stepper.step_until([&] {
    return is_enabled(session, "1.1") && is_enabled(session, "1.2");
  }));
  EXPECT_THAT(peer.log(), HasSubstr("taking control: ros2_test (process "));
}

// Without steps, an axis has not stopped yet when the bridge ends. It therefore stays with the
// session of the bridge, whose Shutdown command stops it in the next ticks.
TEST(Ros2Control, OfAJointThatRunsIsKeptWhenTheBridgeEndsAndTheJointStops) {
  LockStep bench;
  bench.peer().command_velocity({"x"}, {1.0});
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.velocity_demand_value > 0;
  }));
  const std::uint64_t bridge = bench.axis().owner_session;
  ASSERT_NE(bridge, 0U);
  EXPECT_EQ(bench.bridge().stop().code, 0);
  EXPECT_EQ(bench.axis().owner_session, bridge) << "free and running nobody would ever stop it";
  ASSERT_TRUE(bench.session().step(1, 5'000));
  const auto stopped = bench.axis();
  EXPECT_EQ(stopped.state(), PowerState::ready_to_switch_on) << client::what_it_shows(stopped);
  EXPECT_EQ(stopped.status.velocity_demand_value, 0);
}

// ---- joint commands --------------------------------------------------------------------------

TEST(Ros2Commands, MoveToAPositionAndHoldItWithoutFurtherCommands) {
  LockStep bench;
  bench.peer().command({"y", "x"}, {-0.5, 0.25});
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.position_demand_value == std::lround(0.25 / kUnit) &&
           bench.axis("1.2").status.position_demand_value == std::lround(-0.5 / kUnit);
  }));
  for (int i = 0; i < 30; ++i) bench.stepper().step(100);
  EXPECT_TRUE(is_enabled(bench.session(), "1.1"));
  EXPECT_EQ(bench.axis().mode(), OperatingMode::cyclic_synchronous_position);
  EXPECT_NEAR(*bench.peer().position("x"), 0.25, 2 * kUnit);
  EXPECT_NEAR(*bench.peer().position("y"), -0.5, 2 * kUnit);
}

TEST(Ros2Commands, NeverJump) {
  LockStep bench("--enable --rate 1000");
  bench.peer().command({"x"}, {20.0});
  // Default axis: 136,533 UU/s and 409,600 UU/s², so 137 UU and 0.41 UU per tick.
  std::int32_t position = 0;
  std::int32_t step = 0;
  int largest_step = 0;
  for (int tick = 0; tick < 600; ++tick) {
    bench.stepper().step(1);
    const std::int32_t now = bench.axis().status.position_demand_value;
    EXPECT_LE(std::abs(now - position - step), 2) << tick;  // two roundings
    step = now - position;
    largest_step = std::max(largest_step, step);
    position = now;
  }
  EXPECT_GT(largest_step, 50) << "it moves";
  EXPECT_LE(largest_step, 137);
}

TEST(Ros2Commands, AreIgnoredAndLoggedWhenInvalid) {
  LockStep bench;
  RosPeer& peer = bench.peer();
  ros::JointState early;
  early.name = {"x"};
  early.position = {std::nan("")};
  peer.command(early);
  peer.command({"elbow"}, {1.0});
  EXPECT_TRUE(peer.wait_for_log("joint 'elbow' is unknown"));
  peer.command({"x", "y"}, {1.0});
  EXPECT_TRUE(peer.wait_for_log("position has 1 values for 2 names"));
  ros::JointState mixed;
  mixed.name = {"x"};
  mixed.position = {1.0};
  mixed.velocity = {1.0};
  peer.command(mixed);
  EXPECT_TRUE(peer.wait_for_log("'x' has a position and a velocity: refused"));
  peer.command_velocity({"x"}, {1e6});
  EXPECT_TRUE(peer.wait_for_log("is above the limit"));
  peer.command_effort({"x"}, {1e6});
  EXPECT_TRUE(peer.wait([&] {
    return peer.log().find("effort 1e+06") != std::string::npos;
  }));
  ros::JointState stamped;
  stamped.name = {"x"};
  stamped.position = {0.0};
  stamped.header.stamp.sec = 7;
  peer.command(stamped);
  stamped.header.stamp.sec = 6;
  stamped.position = {3.0};
  peer.command(stamped);
  EXPECT_TRUE(peer.wait_for_log("its stamp is 1 s earlier than the previous one"));
  bench.stepper().step(100);
  EXPECT_EQ(bench.axis().status.position_demand_value, 0) << "nothing has moved";
  EXPECT_THAT(peer.log(), Not(HasSubstr("nan")));
}

ros::JointState stamped_command(double position, std::int32_t seconds) {
  ros::JointState message;
  message.name = {"x"};
  message.position = {position};
  message.header.stamp.sec = seconds;
  return message;
}

TEST(Ros2Commands, WithAStampFarAheadAreRefusedAndDoNotStopTheirWriter) {
  LockStep bench;
  bench.peer().command(stamped_command(3.0, 950'400));
  EXPECT_TRUE(
      bench.peer().wait_for_log("s ahead of the time of its bench, more than the "
                                "stamp_ahead of 60 s: the command is ignored"));
  bench.peer().command(stamped_command(10 * kUnit, 1));
  EXPECT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.position_demand_value == 10;
  }));
}

TEST(Ros2Commands, HaveTheirOrderForEachWriterAndAnewAfterEnable) {
  RosPeer other;
  LockStep bench;
  ASSERT_TRUE(bench.stepper().step_until([&other] {
    return other.states() > 0;
  }));
  ASSERT_TRUE(other.wait_for_bridge());
  const auto reaches = [&bench](std::int32_t position) {
    return bench.stepper().step_until([&] {
      return bench.axis().status.position_demand_value == position;
    });
  };
  bench.peer().command(stamped_command(10 * kUnit, 30));
  ASSERT_TRUE(reaches(10));
  other.command(stamped_command(20 * kUnit, 20));
  EXPECT_TRUE(reaches(20)) << "the stamps of another writer";
  bench.peer().command(stamped_command(30 * kUnit, 20));
  EXPECT_TRUE(bench.peer().wait_for_log("its stamp is 10 s earlier than the previous one"));
  bench.peer().enable(true);
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return bench.peer().log().find("enable: true") != std::string::npos &&
           is_enabled(bench.session(), "1.1");
  }));
  bench.peer().command(stamped_command(30 * kUnit, 20));
  EXPECT_TRUE(reaches(30)) << "it starts anew";
}

/// Objects that limit the positions of an axis, the nearest position beyond the limit, and one
/// within.
struct PositionLimits {
  std::vector<std::pair<ObjectAddress, std::int64_t>> objects;
  std::int32_t beyond;
  std::int32_t within;
};

class LimitedCommands : public testing::TestWithParam<PositionLimits> {};

TEST_P(LimitedCommands, ReachNoPositionBeyondTheLimitsOfTheDrive) {
  LockStep bench("");
  auto axis = bench.session().axis("1.1").value();
  for (const auto& [object, value] : GetParam().objects) ASSERT_TRUE(axis.write(object, value));
  bench.peer().enable(true);
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return is_enabled(bench.session(), "1.1");
  }));
  bench.stepper().step(10);
  // The limits are read every two seconds of wall-clock time.
  ASSERT_TRUE(bench.peer().wait([&] {
    bench.peer().command({"x"}, {GetParam().beyond * kUnit});
    return bench.peer().log().find("is beyond the limits") != std::string::npos;
  }));
  bench.peer().command({"x"}, {GetParam().within * kUnit});
  EXPECT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.position_demand_value == GetParam().within;
  }));
}

// 6062h of a modulo axis never shows a position beyond its range, so the bridge would command it
// forever.
INSTANTIATE_TEST_SUITE_P(
    Objects, LimitedCommands,
    testing::Values(
        PositionLimits{{{{0x607D, 1}, -1'000}, {{0x607D, 2}, 1'000}, {{0x3535, 0}, 1}}, 1'001, 999},
        PositionLimits{{{{0x607B, 1}, -2'048}, {{0x607B, 2}, 2'048}}, 2'048, 2'047}));

// Habit e of docs/guides/be-another-drive.md.
TEST(Ros2Commands, MoveADriveThatTakesNoOtherModeWithItsPower) {
  LockStep bench("");
  auto axis = bench.session().axis("1.1").value();
  ASSERT_TRUE(axis.write({0x5E20, 5}, 2));
  bench.peer().enable(true);
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return is_enabled(bench.session(), "1.1");
  }));
  EXPECT_EQ(bench.axis().mode(), OperatingMode::cyclic_synchronous_position);
  bench.stepper().step(10);
  bench.peer().command({"x"}, {100 * kUnit});
  EXPECT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.position_demand_value == 100;
  }));
  bench.peer().command_velocity({"x"}, {2.0});
  EXPECT_TRUE(bench.stepper().step_until([&] {
    return bench.peer().log().find("a command was refused") != std::string::npos;
  })) << bench.peer().log();
  EXPECT_EQ(bench.axis().mode(), OperatingMode::cyclic_synchronous_position);
  EXPECT_EQ(bench.axis().status.velocity_demand_value, 0);
}

// After a pause the bridge's state is out of date: its set-points are for past ticks.
TEST(Ros2Commands, ReachTheirGoalAfterAPauseOfTheBridge) {
  const RunningService service("--clock realtime");
  RosPeer peer;
  RunningBridge bridge("--enable");
  Session session(options());
  ASSERT_TRUE(peer.wait_for_bridge());
  ASSERT_TRUE(peer.wait([&] {
    return is_enabled(session, "1.1");
  }));
  ASSERT_TRUE(peer.wait([&] {  // once its limits are known
    peer.command({"x"}, {0.01});
    return std::abs(*peer.position("x") - 0.01) < 0.001;
  })) << peer.log();
  const auto pass = [&](std::uint64_t ticks) {
    const std::uint64_t until = session.axis("1.1")->status()->tick + ticks;
    ASSERT_TRUE(peer.wait([&] {
      return session.axis("1.1")->status()->tick >= until;
    }));
  };
  for (int round = 1; round <= 10; ++round) {
    const double goal = round % 2 == 0 ? 0.0 : 0.3;
    bridge.pause();
    peer.command({"x"}, {goal});
    pass(static_cast<std::uint64_t>(10 * round));
    bridge.go_on();
    ASSERT_TRUE(peer.wait([&] {
      return std::abs(*peer.position("x") - goal) < 0.001;
    })) << "round "
        << round << ": at " << *peer.position("x") << '\n'
        << peer.log();
  }
}

TEST(Ros2Commands, RunAtAVelocityAndBrakeWhenTheWriterEnds) {
  LockStep bench;
  bench.peer().command_velocity({"x"}, {2.0});
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.velocity_demand_value == std::lround(2.0 / kUnit);
  }));
  EXPECT_EQ(bench.axis().mode(), OperatingMode::cyclic_synchronous_velocity);
  bench.stepper().step(100);
  EXPECT_NEAR(*bench.peer().velocity("x"), 2.0, 0.1);
  bench.peer().stop_commanding();
  ASSERT_TRUE(bench.peer().wait_for_log("the last publisher of joint commands is gone"));
  EXPECT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.velocity_demand_value == 0;
  }));
  EXPECT_TRUE(is_enabled(bench.session(), "1.1"));
}

TEST(Ros2Commands, ChangeTheModeOfAJointThatMoves) {
  LockStep bench;
  bench.peer().command({"x"}, {20.0});
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.velocity_demand_value > 1'000;
  }));
  bench.peer().command_velocity({"x"}, {-2.0});
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.velocity_demand_value == std::lround(-2.0 / kUnit);
  }));
  EXPECT_EQ(bench.axis().mode(), OperatingMode::cyclic_synchronous_velocity);
  bench.peer().command_effort({"x"}, {0.3});  // 100 ‰ of the rated 3 N.m
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().mode() == OperatingMode::cyclic_synchronous_torque &&
           bench.axis().status.torque_demand == 100;
  }));
  bench.peer().command({"x"}, {0.0});
  EXPECT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().mode() == OperatingMode::cyclic_synchronous_position &&
           bench.axis().status.position_demand_value == 0;
  }));
}

TEST(Ros2Commands, OfVelocityDoNotWaitForThe60C2hOfAnotherMaster) {
  LockStep bench("");
  auto axis = bench.session().axis("1.1").value();
  ASSERT_TRUE(axis.write({0x60C2, 1}, 200));
  bench.peer().enable(true);
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return is_enabled(bench.session(), "1.1");
  }));
  bench.stepper().step(10);
  bench.peer().command_velocity({"x"}, {2.0});
  ASSERT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.velocity_demand_value == std::lround(2.0 / kUnit);
  }));
  EXPECT_EQ(axis.read(ObjectAddress{0x60C2, 1}).value(), 0);
}

// ---- trajectories ----------------------------------------------------------------------------

// The curve q(s) = A (s - sin(2 pi s) / 2 pi), s = t / T: at rest at both ends, with v = A / T (1 -
// cos 2 pi s) and a = 2 pi A / T² sin 2 pi s.
struct Curve {
  double amplitude;
  double duration;

  [[nodiscard]] double position(double time) const {
    const double s = std::clamp(time / duration, 0.0, 1.0);
    return amplitude * (s - std::sin(kTurn * s) / kTurn);
  }

  [[nodiscard]] double velocity(double time) const {
    return amplitude / duration * (1.0 - std::cos(kTurn * time / duration));
  }

  [[nodiscard]] double acceleration(double time) const {
    return kTurn * amplitude / (duration * duration) * std::sin(kTurn * time / duration);
  }
};

TEST(Ros2Trajectory, OfFiftyPointsIsFollowedAlongItsAnalyticCurve) {
  LockStep bench;
  const Curve x{.amplitude = 3.0, .duration = 1.0};
  const Curve y{.amplitude = -5.0, .duration = 1.0};
  std::vector<ros::JointTrajectoryPoint> points;
  for (int i = 1; i <= 50; ++i) {
    const double time = i / 50.0;
    const bool is_last = i == 50;
    points.push_back(
        point(time, {x.position(time), y.position(time)},
              {is_last ? 0.0 : x.velocity(time), is_last ? 0.0 : y.velocity(time)},
              {is_last ? 0.0 : x.acceleration(time), is_last ? 0.0 : y.acceleration(time)}));
  }
  const std::uint64_t start = bench.stepper().tick() + 200;
  bench.peer().start(trajectory({"x", "y"}, points, static_cast<std::int64_t>(start) * kTick));
  // The trajectory waits for its start time; its start is reported.
  double furthest = 0.0;
  double largest_error = 0.0;
  bool has_started = false;
  while (bench.stepper().tick() < start + 1'200) {
    bench.stepper().step(10);
    const double time =
        (static_cast<double>(bench.stepper().tick()) - static_cast<double>(start)) * 1e-3;
    const AxisStatus one = bench.axis("1.1").status;
    const AxisStatus other = bench.axis("1.2").status;
    // The demand is the curve rounded to user units; between points, the quintic polynomials
    // deviate from it by less than 1e-6 rad.
    EXPECT_NEAR(one.position_demand_value * kUnit, x.position(time), 0.51 * kUnit + 1e-6) << time;
    EXPECT_NEAR(other.position_demand_value * kUnit, y.position(time), 0.51 * kUnit + 1e-6) << time;
    largest_error = std::max(largest_error,
                             std::abs(other.load_position_actual_value * kUnit - y.position(time)));
    furthest = std::max(furthest, std::abs(other.load_position_actual_value * kUnit));
    has_started = has_started || one.position_demand_value != 0;
  }
  EXPECT_TRUE(has_started);
  EXPECT_NEAR(furthest, 5.0, 2 * kUnit);
  // A position loop of 16 Hz without feed-forward lags by v / (2 pi 16/s); this axis has
  // feed-forward and lags less. The highest velocity is 10 rad/s.
  EXPECT_LT(largest_error, 10.0 / (kTurn * 16.0));
  EXPECT_NEAR(*bench.peer().position("y"), -5.0, 2 * kUnit) << "held at the end";
}

TEST(Ros2Trajectory, ThatStartsIn2038IsRefusedAndTheNextOneStarts) {
  LockStep bench;
  constexpr std::int64_t kLate = 2'145'916'800 * kSecond;
  bench.peer().start(trajectory({"x"}, {point(1.0, {1.0})}, kLate));
  EXPECT_TRUE(
      bench.peer().wait_for_log("joint trajectory: refused: its stamp is 2.14592e+09 s "
                                "ahead of the time of its bench"));
  bench.peer().start(trajectory({"x"}, {point(0.5, {100 * kUnit})}, 2 * kSecond));
  EXPECT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.position_demand_value == 100;
  }));
}

/// @return a trajectory whose message has some 44 bytes per point.
ros::JointTrajectory long_trajectory(std::size_t points) {
  ros::JointTrajectory message;
  message.joint_names = {"x"};
  message.points.reserve(points);
  for (std::size_t i = 0; i < points; ++i) {
    message.points.push_back(point(static_cast<double>(i + 1) * 1e-3, {0.0}));
  }
  return message;
}

TEST(Ros2Trajectory, ThatIsTooLargeToBeReadIsALineInTheLog) {
  LockStep bench;
  bench.peer().start(long_trajectory(200'000));
  EXPECT_TRUE(bench.peer().wait_for_log(" bytes was dropped: at most 4194"));
  bench.peer().start(long_trajectory(1'000'000));
  EXPECT_TRUE(
      bench.peer().wait_for_log("datagrams were dropped, with fragments that do not fit "
                                "their sample, or of a message above 16 MB"));
  bench.peer().command({"x"}, {10 * kUnit});
  EXPECT_TRUE(bench.stepper().step_until([&] {
    return bench.axis().status.position_demand_value == 10;
  })) << "the bridge goes on";
}

// ---- several benches, restarts ---------------------------------------------------------------

/// Two benches in lock-step, with their axes bench1_x, bench1_y, bench2_x and bench2_y enabled.
class TwoBenches {
 public:
  TwoBenches()
      : first_("--clock lockstep --bench 1"),
        second_("--clock lockstep --bench 2"),
        bridge_("--enable --prefix --bench 1 --bench 2"),
        session_(options()),
        one_(session_, peer_, 1, "bench1_x"),
        two_(session_, peer_, 2, "bench2_x") {
    const bool are_found = peer_.wait_for_bridge() && peer_.wait([this] {
      return peer_.state("bench1_x") && peer_.state("bench2_x");
    });
    if (!are_found) throw std::runtime_error("no bridge");
    for (int i = 0; i < 100 && !are_enabled(); ++i) step();
    if (!are_enabled()) throw std::runtime_error("the axes were not enabled");
    step();
  }

  ~TwoBenches() {
    if (testing::Test::HasFailure()) std::cerr << peer_.log();
  }

  TwoBenches(const TwoBenches&) = delete;
  TwoBenches& operator=(const TwoBenches&) = delete;

  void step() {
    one_.step(10);
    two_.step(10);
  }

  [[nodiscard]] RosPeer& peer() { return peer_; }

  [[nodiscard]] Session& session() { return session_; }

  [[nodiscard]] std::int32_t demand(const std::string& axis) {
    return session_.axis(axis)->status()->status.position_demand_value;
  }

 private:
  bool are_enabled() { return is_enabled(session_, "1.1") && is_enabled(session_, "2.1"); }

  RunningService first_;
  RunningService second_;
  RosPeer peer_;
  RunningBridge bridge_;
  Session session_;
  Stepper one_;
  Stepper two_;
};

TEST(Ros2, ServesTwoBenchesWithOneTrajectory) {
  TwoBenches benches;
  RosPeer& peer = benches.peer();
  peer.start(trajectory({"bench1_x", "bench2_x"}, {point(0.5, {1.0, -2.0}, {0.0, 0.0})}));
  ASSERT_TRUE(peer.wait_for_log("of bench1_x, bench2_x, 1 points: starts"));
  for (int i = 0; i < 100; ++i) benches.step();
  EXPECT_NEAR(*peer.position("bench1_x"), 1.0, 2 * kUnit);
  EXPECT_NEAR(*peer.position("bench2_x"), -2.0, 2 * kUnit);
}

TEST(Ros2, StopsTheJointsOfATrajectoryOnAnotherBenchWhenAnAxisFails) {
  TwoBenches benches;
  RosPeer& peer = benches.peer();
  peer.start(trajectory({"bench1_x", "bench2_x"}, {point(4.0, {6.0, 6.0}, {0.0, 0.0})}));
  for (int i = 0; i < 400 && benches.demand("2.1") < 500; ++i) benches.step();
  ASSERT_GE(benches.demand("2.1"), 500);
  ASSERT_TRUE(benches.session().axis("1.1")->disturb(client::Disturbance::encoder_failure));
  for (int i = 0; i < 5; ++i) benches.step();
  EXPECT_TRUE(peer.wait_for_log("stopped, joint bench1_x shows"));
  // 6 rad in 4 s on a cubic: at most 2.25 rad/s. The ramp of the default axis, 409,600 UU/s² = 628
  // rad/s², stops that within 4 ticks. Up to 100 ticks of set-points may be in transit.
  for (int i = 0; i < 20; ++i) benches.step();
  const std::int32_t rest = benches.demand("2.1");
  EXPECT_LT(rest, std::lround(5.0 / kUnit));
  for (int i = 0; i < 50; ++i) benches.step();
  EXPECT_EQ(benches.demand("2.1"), rest) << "it stays where it came to rest";
  EXPECT_TRUE(is_enabled(benches.session(), "2.1"));
  peer.command({"bench2_x"}, {0.5});
  for (int i = 0; i < 200 && benches.demand("2.1") != std::lround(0.5 / kUnit); ++i) benches.step();
  EXPECT_EQ(benches.demand("2.1"), std::lround(0.5 / kUnit)) << "it takes commands again";
}

TEST(Ros2, ContinuesAfterARestartOfTheService) {
  auto service = std::make_unique<RunningService>("--clock lockstep");
  RosPeer peer;
  RunningBridge bridge("--enable");
  ASSERT_TRUE(peer.wait_for_bridge());
  service->kill();
  EXPECT_TRUE(peer.wait([&] {
    return peer.diagnosis("bench 1").starts_with("3 ");
  })) << peer.diagnosis("bench 1");
  service = std::make_unique<RunningService>("--clock lockstep");
  ASSERT_TRUE(peer.wait_for_log("was restarted"));
  Session session(options());
  Stepper stepper(session, peer);
  EXPECT_TRUE(stepper.step_until([&] {
    return is_enabled(session, "1.1");
  }));
  stepper.step(10);
  peer.command({"x"}, {0.5});
  EXPECT_TRUE(stepper.step_until([&] {
    const auto position = peer.position("x");
    return position && std::abs(*position - 0.5) < 2 * kUnit;
  }));
}

#ifdef VDRIVE_ROS2_PLUGIN
// In real time: another vendor's program that behaves like the ros2_control plugin. It writes NaN
// first, then a sine on two of three joints at 100 Hz, then nothing for ten seconds.
TEST(Ros2Plugin, OfAnotherVendorMovesTwoAxesAndCanStopWritingForTenSeconds) {
  const RunningService service("--axes 3");
  Session session(options());
  const auto axes = session.axes(1);
  ASSERT_TRUE(axes);
  RunningBridge bridge("--enable");
  ASSERT_TRUE((*axes)[1].wait_until(
      [](const client::AxisSnapshot& axis) {
        return axis.state() == PowerState::operation_enabled;
      },
      30s));
  const Finished plugin = Process(VDRIVE_ROS2_PLUGIN, {std::to_string(test_domain()),
                                                       (*axes)[0].name(), (*axes)[1].name()})
                              .wait();
  EXPECT_EQ(plugin.code, 0) << plugin.output << plugin.errors;
  for (const client::Axis& axis : *axes) {
    const auto status = axis.status();
    ASSERT_TRUE(status);
    EXPECT_EQ(status->state(), PowerState::operation_enabled)
        << "the watchdog has not tripped: " << client::what_it_shows(*status);
    EXPECT_EQ(status->status.fault_count, 0U);
  }
  EXPECT_EQ((*axes)[2].status()->status.position_demand_value, 0) << "it was not commanded";
}
#endif

}  // namespace
}  // namespace vdrive::test
