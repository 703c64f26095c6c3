// SPDX-License-Identifier: Apache-2.0
// Axis::home, run_at, apply_torque and jog; a stream of one axis; Session::on_status.
#include "client/objects.hpp"
#include "client/reports.hpp"
#include "support/bench_on_wire.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::options_on_wire;
using testing::AllOf;
using testing::HasSubstr;

CallOptions in_force() {
  return {.until = Until::in_force};
}

/// An enabled axis in lock-step.
class Modes : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(axis_.enable()); }

  [[nodiscard]] std::int64_t value_of(ObjectAddress object) const {
    const auto value = axis_.read(object);
    EXPECT_TRUE(value) << value.outcome().message();
    return value ? *value : -1;
  }

  [[nodiscard]] AxisSnapshot now() const { return axis_.status().value(); }

 private:
  test::BenchOnWire bench_{"--clock lockstep"};

 protected:
  Session session_{options_on_wire()};
  Axis axis_ = *session_.axis("1.1");
};

// Method 37 takes the present position as home.
TEST_F(Modes, HomeReachesTheHomePositionAndSetsItsValue) {
  const Outcome homed = axis_.home({.method = 37, .offset = -500, .call = {}});
  EXPECT_TRUE(homed) << homed.message();
  EXPECT_EQ(now().mode(), OperatingMode::homing);
  EXPECT_TRUE(now().shows(Statusword::kHomingAttained | Statusword::kTargetReached));
  EXPECT_EQ(value_of(kDemand), -500);
  EXPECT_TRUE(axis_.home()) << "bit 4 has dropped: the next run has its edge";
  EXPECT_TRUE(axis_.move_to(100)) << "a move sets its own mode";
}

TEST_F(Modes, HomeWithoutAMethodEndsInAHomingError) {
  const Outcome failed = axis_.home({.method = 0, .call = {}});
  EXPECT_EQ(failed.kind(), OutcomeKind::failed);
  EXPECT_THAT(failed.message(), HasSubstr("homing error, bit 13, with homing_method (6098h) = 0"));
  const Outcome refused = axis_.home({.method = 15, .call = {}});
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_THAT(refused.message(), HasSubstr("homing_method"));
}

TEST_F(Modes, HomeFailsAfterAHaltAndASecondHomeIsRefusedDuringTheFirst) {
  ASSERT_TRUE(
      axis_.home({.method = 17, .search_speed = 100, .creep_speed = 100, .call = in_force()}));
  ASSERT_TRUE(session_.step(1, 10));
  EXPECT_EQ(axis_.home().code(), kRefusedInState);
  ASSERT_TRUE(axis_.halt());
}

// Values already in 6099h are limited by the drive; only values given in the call are refused.
TEST_F(Modes, HomeWithAnUnreachableSpeedIsRefused) {
  ASSERT_TRUE(axis_.write(kSpeedLimit, 5'000));
  const Outcome search = axis_.home({.method = 17, .search_speed = 5'001, .call = {}});
  EXPECT_EQ(search.code(), kRefusedInState);
  EXPECT_THAT(search.message(),
              HasSubstr("the homing_speed_search (6099h:1) 5001 UU/s (439.54 deg/s) "
                        "is above app_speed_limit (607Fh) = 5000 UU/s"));
  const Outcome creep = axis_.home({.method = 17, .creep_speed = 5'001, .call = {}});
  EXPECT_EQ(creep.code(), kRefusedInState);
  EXPECT_THAT(creep.message(),
              HasSubstr("the homing_speed_creep (6099h:2) 5001 UU/s (439.54 deg/s) is above"));
  EXPECT_EQ(now().mode(), OperatingMode::none) << "nothing was changed";
  EXPECT_TRUE(axis_.home({.method = 37, .search_speed = 5'000, .creep_speed = 5'000, .call = {}}));
}

// There is no switch: at 100 UU/s the axis travels 100 UU in the 1 s.
TEST_F(Modes, ALateHomingRunSaysThatTheAxisIsStillMoving) {
  const Outcome late =
      axis_.home({.method = 17, .search_speed = 100, .creep_speed = 100, .call = {.timeout = 1s}});
  EXPECT_EQ(late.kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.message(),
              AllOf(HasSubstr("axis 1.1: timed out while waiting for the end of the homing run"),
                    HasSubstr(" deg), still moving at -100 UU/s (-8.79 deg/s)")));
  EXPECT_TRUE(axis_.halt());
}

// At 1000 UU/s² the velocity is reached after 10 s.
TEST_F(Modes, ALateVelocitySaysHowFastTheAxisIs) {
  const Outcome late = axis_.run_at(10'000, {.acceleration = 1'000, .call = {.timeout = 1s}});
  EXPECT_EQ(late.kind(), OutcomeKind::timed_out);
  EXPECT_THAT(
      late.message(),
      testing::MatchesRegex(
          "axis 1\\.1: timed out while waiting for the velocity, bit 10, "
          "at [0-9]+ UU/s \\([0-9.]+ deg/s\\) of 10000 UU/s \\(878.91 deg/s\\), still changing"));
  EXPECT_TRUE(axis_.halt());
}

// At 10 ‰/s the torque reaches 20 ‰ of 100 ‰ in 2 s.
TEST_F(Modes, ALateTorqueSaysHowMuchIsApplied) {
  const Outcome late = axis_.apply_torque(100, {.slope = 10, .call = {.timeout = 2s}});
  EXPECT_EQ(late.kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.message(),
              AllOf(HasSubstr("timed out while waiting for the torque, bit 10, at "),
                    HasSubstr(" of 100 per mille of rated torque, still changing")));
  EXPECT_TRUE(axis_.apply_torque(0));
}

TEST_F(Modes, RunAtReachesTheVelocityAndHoldsIt) {
  const Outcome reached = axis_.run_at(-20'000, {.acceleration = 200'000, .call = {}});
  ASSERT_TRUE(reached) << reached.message();
  EXPECT_EQ(now().mode(), OperatingMode::profile_velocity);
  EXPECT_EQ(value_of(kTargetVelocity), -20'000);
  EXPECT_EQ(value_of(kAcceleration), 200'000) << "what is given stays";
  ASSERT_TRUE(session_.step(1, 100));
  EXPECT_EQ(now().status.velocity_demand_value, -20'000);
  ASSERT_TRUE(axis_.run_at(0));
  EXPECT_EQ(now().status.velocity_demand_value, 0);
}

TEST_F(Modes, RunAtAnUnreachableVelocityIsRefused) {
  ASSERT_TRUE(axis_.write(kSpeedLimit, 5'000));
  EXPECT_THAT(axis_.run_at(5'001).message(),
              HasSubstr("the velocity 5001 UU/s (439.54 deg/s) is above app_speed_limit (607Fh) = "
                        "5000 UU/s (439.45 deg/s)"));
  EXPECT_THAT(axis_.run_at(100, {.acceleration = 0, .call = {}}).message(),
              HasSubstr("profile_acc (6083h) is 0"));
  EXPECT_EQ(now().mode(), OperatingMode::none);
  ASSERT_TRUE(axis_.disable());
  EXPECT_EQ(axis_.run_at(100).code(), kRefusedInState);
}

// A value already in 6081h is limited by the drive to 607Fh; only a value given in the call is
// refused.
TEST_F(Modes, AMoveWithAnUnreachableVelocityIsRefusedAsWell) {
  ASSERT_TRUE(axis_.write(kSpeedLimit, 5'000));
  const Outcome refused = axis_.move_to(100, {.velocity = 5'001});
  EXPECT_EQ(refused.code(), kRefusedInState);
  EXPECT_THAT(refused.message(),
              HasSubstr("the velocity 5001 UU/s (439.54 deg/s) is above app_speed_limit (607Fh) = "
                        "5000 UU/s (439.45 deg/s)"));
  EXPECT_EQ(now().mode(), OperatingMode::none) << "nothing was changed";
  EXPECT_TRUE(axis_.move_to(100, {.velocity = 5'000}));
  ASSERT_TRUE(axis_.disable());
  ASSERT_TRUE(axis_.enable());  // 607Fh takes effect here
  EXPECT_TRUE(axis_.move_to(0)) << "6081h = 68267 is cut to 607Fh, as in the manual";
}

// 60 rpm are 4096 UU/s.
TEST_F(Modes, RunAtAboveTheSpeedOfTheMotorIsRefused) {
  ASSERT_TRUE(axis_.disable());
  ASSERT_TRUE(axis_.write(kMotorSpeed, 60));
  ASSERT_TRUE(axis_.enable());
  const Outcome refused = axis_.run_at(-4'097);
  EXPECT_EQ(refused.code(), kRefusedInState);
  EXPECT_THAT(
      refused.message(),
      HasSubstr(
          "the velocity -4097 UU/s (-360.09 deg/s) is above motor_speed_limit (5E11h) = "
          "4096 UU/s (360.00 deg/s), which follows from motor_max_speed_rpm (6080h) and the gear"));
  EXPECT_EQ(now().mode(), OperatingMode::none) << "nothing was changed";
  EXPECT_TRUE(axis_.run_at(-4'096));
}

// 607Fh takes effect at the next enabling. 5000 UU/s are reached within 13 ms.
TEST_F(Modes, RunAtReportsTheSpeedLimitThatWasLatchedAtEnabling) {
  ASSERT_TRUE(axis_.disable());
  ASSERT_TRUE(axis_.write(kSpeedLimit, 5'000));
  ASSERT_TRUE(axis_.enable());
  ASSERT_TRUE(axis_.write(kSpeedLimit, 20'000));
  const std::uint64_t start = now().tick;
  const Outcome cut = axis_.run_at(8'000);
  EXPECT_EQ(cut.kind(), OutcomeKind::failed);
  EXPECT_THAT(
      cut.message(),
      AllOf(HasSubstr(
                "the velocity of 8000 UU/s (703.12 deg/s) is limited to 5000 UU/s (439.45 deg/s)"),
            HasSubstr("app_speed_limit (607Fh)")));
  EXPECT_LT(now().tick, start + 200);
}

// At 40 UU/s² the demand reaches a new integer every 25 ms; 606Dh = 100 is reached after 500 ms.
TEST_F(Modes, RunAtWaitsForASlowRamp) {
  const Outcome reached = axis_.run_at(120, {.acceleration = 40, .call = {}});
  EXPECT_TRUE(reached) << reached.message();
}

TEST_F(Modes, RunAtIntoALimitSwitchIsReportedAtOnce) {
  ASSERT_TRUE(axis_.disturb(Disturbance::negative_limit));
  const std::uint64_t start = now().tick;
  const Outcome ended = axis_.run_at(-2'000);
  EXPECT_EQ(ended.kind(), OutcomeKind::failed);
  EXPECT_THAT(ended.message(),
              HasSubstr("the negative limit switch (60FDh bit 0) ended the velocity of -2000"));
  EXPECT_LT(now().tick, start + 20);
  EXPECT_TRUE(axis_.run_at(2'000)) << "the other way is free";
}

TEST_F(Modes, ApplyTorqueAboveALimitIsRefused) {
  ASSERT_TRUE(axis_.write(kMaxTorque, 300));
  ASSERT_TRUE(axis_.write(kPositiveTorqueLimit, 20));
  ASSERT_TRUE(axis_.write(kNegativeTorqueLimit, 10));
  EXPECT_THAT(axis_.apply_torque(301).message(),
              HasSubstr("the torque 301 is above max_torque (6072h) = 300"));
  EXPECT_THAT(axis_.apply_torque(21).message(),
              HasSubstr("the torque 21 is above positive_torque_limit_relative (60E0h) = 20"));
  const Outcome refused = axis_.apply_torque(-11);
  EXPECT_EQ(refused.code(), kRefusedInState);
  EXPECT_THAT(refused.message(),
              HasSubstr("the torque -11 is above negative_torque_limit_relative (60E1h) = 10"));
  EXPECT_EQ(now().mode(), OperatingMode::none) << "nothing was changed";
  EXPECT_TRUE(axis_.apply_torque(20)) << "the limit itself can be applied";
}

// At half the rated current, 60E0h = 40 ‰ of it gives 20 ‰ of the rated torque.
TEST_F(Modes, ApplyTorqueReportsALimitThatClampsTheTorque) {
  ASSERT_TRUE(axis_.write(kRatedCurrent, 2'500));
  ASSERT_TRUE(axis_.write(kPositiveTorqueLimit, 40));
  const std::uint64_t start = now().tick;
  const Outcome cut = axis_.apply_torque(30);
  EXPECT_EQ(cut.kind(), OutcomeKind::failed);
  EXPECT_THAT(cut.message(), AllOf(HasSubstr("the torque of 30 is limited to 20"),
                                   HasSubstr("positive_torque_limit_relative (60E0h)")));
  EXPECT_LT(now().tick, start + 200);
}

TEST_F(Modes, ApplyTorqueIntoALimitSwitchIsReportedAtOnce) {
  ASSERT_TRUE(axis_.disturb(Disturbance::positive_limit));
  EXPECT_THAT(axis_.apply_torque(20).message(),
              HasSubstr("the positive limit switch (60FDh bit 1) ended the torque of 20"));
}

TEST_F(Modes, ApplyTorqueReachesTheTorque) {
  const Outcome reached = axis_.apply_torque(30, {.slope = 1'000, .call = {}});
  ASSERT_TRUE(reached) << reached.message();
  EXPECT_EQ(now().mode(), OperatingMode::profile_torque);
  EXPECT_EQ(value_of(kTorqueDemand), 30);
  ASSERT_TRUE(axis_.apply_torque(0));
  EXPECT_EQ(value_of(kTorqueDemand), 0);
}

// At 10000 UU/s for 100 ms the axis travels some 1000 UU and brakes from there.
TEST_F(Modes, JogRunsWhileItIsHeldAndThenStops) {
  std::uint64_t first = 0;
  std::int32_t fastest = 0;
  const Outcome jogged = axis_.jog(10'000, [&](const AxisSnapshot& axis) {
    if (first == 0) first = axis.tick;
    fastest = std::max(fastest, axis.status.velocity_demand_value);
    return axis.tick < first + 100;
  });
  ASSERT_TRUE(jogged) << jogged.message();
  EXPECT_EQ(fastest, 10'000);
  EXPECT_EQ(now().status.velocity_demand_value, 0);
  EXPECT_EQ(value_of(kTargetVelocity), 0);
  EXPECT_GT(now().status.load_position_actual_value, 500);
}

TEST_F(Modes, JogStopsAfterAnInterrupt) {
  const Outcome jogged = axis_.jog(10'000, [&](const AxisSnapshot& axis) {
    if (axis.status.velocity_demand_value == 10'000) session_.interrupt();
    return true;
  });
  EXPECT_TRUE(jogged) << jogged.message();
  Session other(options_on_wire());
  const auto status = other.axis("1.1")->status();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->status.velocity_demand_value, 0);
}

// Another program takes over the axis and ends, which releases the axis. A free axis has no
// watchdog, and the epoch of the jog's last command is no longer valid.
TEST_F(Modes, JogWhoseLastCommandIsRefusedStopsItsAxisByAQuickStop) {
  const Outcome jogged = axis_.jog(10'000, [&](const AxisSnapshot& axis) {
    if (axis.status.velocity_demand_value == 10'000) {
      Session other(options_on_wire());
      EXPECT_TRUE(other.axis("1.1").value().take_over());
    }
    return true;  // the button is never released
  });
  EXPECT_EQ(jogged.kind(), OutcomeKind::refused);
  EXPECT_THAT(jogged.message(), HasSubstr("a quick stop ended the jog: bench 1 refused"));
  EXPECT_EQ(now().owner_session, session_.id()) << "taken again, for 60FFh = 0";
  EXPECT_EQ(now().status.velocity_demand_value, 0);
  EXPECT_EQ(now().state(), PowerState::switch_on_disabled);
}

// An axis would also run on if another program takes it over and sends no command.
TEST_F(Modes, JogStopsAnAxisThatAnotherSessionHasTakenAndNotCommanded) {
  Session other(options_on_wire());
  const Outcome jogged = axis_.jog(10'000, [&](const AxisSnapshot& axis) {
    if (axis.status.velocity_demand_value == 10'000) {
      EXPECT_TRUE(other.axis("1.1").value().take_over());
    }
    return true;
  });
  EXPECT_EQ(jogged.kind(), OutcomeKind::refused);
  EXPECT_THAT(jogged.message(), HasSubstr("a quick stop ended the jog: "));
  EXPECT_EQ(now().owner_session, other.id());
  EXPECT_EQ(now().status.velocity_demand_value, 0);
}

TEST_F(Modes, JogLeavesAnAxisThatAnotherSessionCommandsToThatSession) {
  Session other(options_on_wire());
  const Outcome jogged = axis_.jog(10'000, [&](const AxisSnapshot& axis) {
    if (axis.status.velocity_demand_value == 10'000) {
      Axis taken = other.axis("1.1").value();
      EXPECT_TRUE(taken.take_over());
      EXPECT_TRUE(taken.run_at(2'000, {.call = {.until = Until::done}}));
    }
    return true;
  });
  EXPECT_EQ(jogged.kind(), OutcomeKind::refused);
  EXPECT_THAT(jogged.message(), HasSubstr("axis 1.1 is controlled by "));
  EXPECT_EQ(now().owner_session, other.id());
  EXPECT_EQ(now().status.velocity_demand_value, 2'000);
}

TEST_F(Modes, JogWhoseProgramThrowsStopsItsAxis) {
  EXPECT_THROW((void)axis_.jog(10'000,
                               [](const AxisSnapshot& axis) {
                                 if (axis.status.velocity_demand_value == 10'000) throw 1;
                                 return true;
                               }),
               int);
  EXPECT_EQ(now().status.velocity_demand_value, 0);
  EXPECT_EQ(value_of(kTargetVelocity), 0);
}

/// The state of axis 1.1 after the end of a program that may have set it in motion.
class EndOfAProgram : public testing::Test {
 protected:
  /// Runs `call` with an enabled axis in a session that ends afterwards. @return the session.
  template <typename Call>
  std::uint64_t run(const Call& call) {
    Session session(options_on_wire());
    Axis axis = session.axis("1.1").value();
    EXPECT_TRUE(axis.enable());
    call(session, axis);
    return session.id();
  }

  [[nodiscard]] AxisSnapshot now() { return axis_.status().value(); }

  /// Expects the watchdog of 500 ms to act and the axis to stop.
  void expect_stop_by_the_watchdog(std::uint64_t owner) {
    EXPECT_EQ(now().owner_session, owner) << "free and running nobody would ever stop it";
    ASSERT_TRUE(watcher_.step(1, 600));
    EXPECT_EQ(now().status.error_code, 0x8130);
    ASSERT_TRUE(watcher_.step(1, 2'000));
    EXPECT_EQ(now().state(), PowerState::fault);
    EXPECT_EQ(now().status.velocity_demand_value, 0);
  }

  test::BenchOnWire bench_{"--clock lockstep"};
  Session watcher_{options_on_wire()};
  Axis axis_ = watcher_.axis("1.1").value();
};

// At 100 UU/s² the velocity is reached after 100 s.
TEST_F(EndOfAProgram, LeavesAnAxisThatDidNotReachItsVelocityToTheWatchdog) {
  const std::uint64_t program = run([](Session& session, Axis& axis) {
    const Outcome late = axis.run_at(10'000, {.acceleration = 100, .call = {.timeout = 1s}});
    EXPECT_EQ(late.kind(), OutcomeKind::timed_out);
    const Outcome kept = session.release();
    EXPECT_EQ(kept.kind(), OutcomeKind::failed);
    EXPECT_THAT(kept.message(), HasSubstr("axis 1.1 was not released"));
  });
  expect_stop_by_the_watchdog(program);
}

TEST_F(EndOfAProgram, LeavesAnAxisThatDidNotReachItsTorqueToTheWatchdog) {
  const std::uint64_t program = run([](Session& /*session*/, Axis& axis) {
    EXPECT_EQ(axis.apply_torque(100, {.slope = 10, .call = {.timeout = 2s}}).kind(),
              OutcomeKind::timed_out);
  });
  expect_stop_by_the_watchdog(program);
}

TEST_F(EndOfAProgram, LeavesAnAxisThatIsStreamedToTheWatchdog) {
  const std::uint64_t program = run([](Session& session, Axis& axis) {
    auto group = AxisGroup::create(session, std::vector<Axis>{axis});
    ASSERT_TRUE(group && group->start_streaming());
    for (int i = 1; i <= 10; ++i) {
      ASSERT_TRUE(group->stream(Eigen::VectorXd::Constant(1, 7.0 * i)));
    }
  });
  EXPECT_EQ(now().owner_session, program);
  ASSERT_TRUE(watcher_.step(1, 600));
  EXPECT_EQ(now().status.error_code, 0x8130);
}

TEST_F(EndOfAProgram, LeavesAnAxisThatRunsBySetPointsToTheWatchdog) {
  const std::uint64_t program = run([](Session& session, Axis& axis) {
    const SetPointFrame frame{
        .axes = {{.axis = 1, .mode = OperatingMode::profile_velocity, .velocity = 5'000}}};
    ASSERT_TRUE(session.send_set_points(1, {&frame, 1}));
    ASSERT_TRUE(axis.wait_until(
        [](const AxisSnapshot& seen) {
          return seen.status.velocity_demand_value == 5'000;
        },
        20s));
  });
  expect_stop_by_the_watchdog(program);
}

// 6042h is not a member of a set-point. 60 rpm are 4096 UU/s, at 4096 UU a revolution.
TEST_F(EndOfAProgram, LeavesAnAxisThatRunsByAnObjectOfASetPointToTheWatchdog) {
  const std::uint64_t program = run([](Session& session, Axis& axis) {
    const SetPointFrame frame{.axes = {{.axis = 1,
                                        .mode = OperatingMode::velocity,
                                        .controlword = 0x007F,
                                        .objects = {{.object = {0x6042, 0}, .value = 60}}}}};
    ASSERT_TRUE(session.send_set_points(1, {&frame, 1}));
    ASSERT_TRUE(axis.wait_until(
        [](const AxisSnapshot& seen) {
          return seen.status.velocity_demand_value == 4'096;
        },
        20s));
  });
  expect_stop_by_the_watchdog(program);
}

TEST_F(EndOfAProgram, GivesAnAxisBackThatWasSeenToStop) {
  (void)run([](Session& session, Axis& axis) {
    EXPECT_FALSE(axis.run_at(10'000, {.acceleration = 100, .call = {.timeout = 1s}}));
    EXPECT_TRUE(axis.halt());
    EXPECT_TRUE(session.release());
  });
  EXPECT_EQ(now().owner_session, 0U);
  EXPECT_EQ(now().state(), PowerState::operation_enabled);
}

TEST_F(EndOfAProgram, GivesAnAxisBackWhoseJogOrStreamHasEnded) {
  (void)run([](Session& session, Axis& axis) {
    int ticks = 0;
    EXPECT_TRUE(axis.jog(1'000, [&ticks](const AxisSnapshot&) {
      return ++ticks < 20;
    }));
    EXPECT_TRUE(session.release());
    auto group = AxisGroup::create(session, std::vector<Axis>{axis});
    ASSERT_TRUE(group && group->start_streaming());
    const double position = axis.status().value().status.position_demand_value;
    ASSERT_TRUE(group->stream(Eigen::VectorXd::Constant(1, position + 1.0)));
    EXPECT_TRUE(group->stop_streaming());
    EXPECT_TRUE(session.release());
  });
  EXPECT_EQ(now().owner_session, 0U);
}

TEST_F(EndOfAProgram, GivesAnAxisBackWhoseVelocityWasRefused) {
  (void)run([](Session& /*session*/, Axis& axis) {
    EXPECT_EQ(axis.run_at(2'000'000'000).kind(), OutcomeKind::refused);
  });
  EXPECT_EQ(now().owner_session, 0U);
  ASSERT_TRUE(watcher_.step(1, 1'000));
  EXPECT_EQ(now().state(), PowerState::operation_enabled);
}

// Axis::run_at() promises: the axis keeps running, "if it has reached the velocity, also after the
// session".
TEST_F(EndOfAProgram, GivesAnAxisBackThatHasReachedTheVelocityItWasToKeep) {
  (void)run([](Session& /*session*/, Axis& axis) {
    EXPECT_TRUE(axis.run_at(5'000));
  });
  EXPECT_EQ(now().owner_session, 0U);
  EXPECT_EQ(now().status.velocity_demand_value, 5'000);
}

TEST_F(Modes, JogEndsWithTheFaultThatStopsTheAxis) {
  int ticks = 0;
  const Outcome failed = axis_.jog(10'000, [&](const AxisSnapshot&) {
    ++ticks;
    if (ticks == 20) {
      EXPECT_TRUE(axis_.disturb(Disturbance::over_current));
    }
    return ticks < 1'000;
  });
  EXPECT_EQ(failed.kind(), OutcomeKind::failed);
  EXPECT_LT(ticks, 100);
}

// 10 positions, 7 UU apart. The demand follows each in its tick, even after a master that had 60C2h
// at 20 ms.
TEST_F(Modes, AGroupOfOneStreamsAnAxis) {
  ASSERT_TRUE(axis_.write({0x60C2, 1}, 20));
  auto group = AxisGroup::create(session_, std::vector<Axis>{axis_});
  ASSERT_TRUE(group);
  ASSERT_TRUE(group->start_streaming());
  for (int i = 1; i <= 10; ++i) {
    const auto status = group->stream(Eigen::VectorXd::Constant(1, 7.0 * i));
    ASSERT_TRUE(status) << status.outcome().message();
    EXPECT_EQ(status->axes.front().status.position_demand_value, 7 * i);
  }
  EXPECT_TRUE(group->stop_streaming());
}

// 606Bh is the velocity at the end of the tick; another master's offset has no effect.
TEST_F(Modes, AGroupOfOneStreamsVelocities) {
  ASSERT_TRUE(axis_.write({0x60B1, 0}, 500));
  auto group = AxisGroup::create(session_, std::vector<Axis>{axis_});
  ASSERT_TRUE(group);
  ASSERT_TRUE(group->start_streaming({.what = Streamed::velocities}));
  EXPECT_EQ(now().mode(), OperatingMode::cyclic_synchronous_velocity);
  for (int i = 1; i <= 10; ++i) {
    const auto status = group->stream(Eigen::VectorXd::Constant(1, 100.0 * i));
    ASSERT_TRUE(status) << status.outcome().message();
    EXPECT_EQ(status->axes.front().status.velocity_demand_value, 100 * i);
    EXPECT_TRUE(status->not_following().empty());
  }
  EXPECT_THAT(group->stream(Eigen::VectorXd::Constant(1, 3.0e9)).outcome().message(),
              HasSubstr("the velocity 3000000000.000000 does not fit in 32 bits"));
  EXPECT_TRUE(group->stop_streaming());
  EXPECT_EQ(now().status.velocity_demand_value, 0);
}

// 6074h is the command of the last of 8 servo cycles, an eighth of a tick before the end of the
// tick.
TEST_F(Modes, AGroupOfOneStreamsTorques) {
  auto group = AxisGroup::create(session_, std::vector<Axis>{axis_});
  ASSERT_TRUE(group);
  ASSERT_TRUE(group->start_streaming({.what = Streamed::torques}));
  for (int i = 1; i <= 10; ++i) {
    const auto status = group->stream(Eigen::VectorXd::Constant(1, 8.0 * i));
    ASSERT_TRUE(status) << status.outcome().message();
    EXPECT_EQ(status->axes.front().status.torque_demand, 8 * i - 1);
  }
  EXPECT_THAT(group->stream(Eigen::VectorXd::Constant(1, 40'000.0)).outcome().message(),
              HasSubstr("the torque 40000.000000 does not fit in 16 bits"));
  EXPECT_TRUE(group->stop_streaming());
  EXPECT_EQ(now().mode(), OperatingMode::profile_position);
}

TEST_F(EndOfAProgram, LeavesAnAxisThatIsStreamedATorqueToTheWatchdog) {
  const std::uint64_t program = run([](Session& session, Axis& axis) {
    auto group = AxisGroup::create(session, std::vector<Axis>{axis});
    ASSERT_TRUE(group && group->start_streaming({.what = Streamed::torques}));
    for (int i = 1; i <= 10; ++i) ASSERT_TRUE(group->stream(Eigen::VectorXd::Constant(1, 10.0)));
  });
  EXPECT_EQ(now().owner_session, program);
  ASSERT_TRUE(watcher_.step(1, 600));
  EXPECT_EQ(now().status.error_code, 0x8130);
}

TEST(OnStatus, ReportsNewerTicksOfTheAxesUntilItIsEnded) {
  const test::BenchOnWire bench("");
  Session session(options_on_wire());
  test::Reports reports;
  const std::vector<AxisId> axes{{1, 2}, {1, 1}};
  ASSERT_TRUE(session.on_status(axes, 20ms, reports.keeper()));
  ASSERT_TRUE(reports.wait_for(5));
  ASSERT_TRUE(session.on_status({}, 20ms, {}));
  const std::size_t count = reports.count();
  for (std::size_t i = 0; i < reports.seen.size(); ++i) {
    ASSERT_EQ(reports.seen[i].axes.size(), 2U);
    EXPECT_EQ(reports.seen[i].axes[0].id, (AxisId{1, 2})) << "in the order of the request";
    if (i > 0) {
      EXPECT_GT(reports.seen[i].tick, reports.seen[i - 1].tick);
    }
  }
  ASSERT_TRUE(session.wait(1, 100ms));
  EXPECT_EQ(reports.count(), count) << "nothing comes after its end";
}

TEST(OnStatus, HasAPeriodOfAMillisecondOrMore) {
  const test::BenchOnWire bench("");
  Session session(options_on_wire());
  const std::vector<AxisId> axes{{1, 1}};
  const auto ignore = [](const Observation&) {};
  for (const auto period : {0ms, -5ms}) {
    EXPECT_EQ(session.on_status(axes, period, ignore).kind(), OutcomeKind::failed);
    const Outcome refused = session.report_status(axes, period, ignore).outcome();
    EXPECT_EQ(refused.kind(), OutcomeKind::failed);
    EXPECT_THAT(refused.message(), HasSubstr("it must be 1 ms or more"));
  }
}

TEST(OnStatus, OfAMissingAxisIsNotFound) {
  const test::BenchOnWire bench("");
  Session session(options_on_wire());
  const std::vector<AxisId> axes{{1, 1}, {1, 9}};
  EXPECT_EQ(session.on_status(axes, 20ms, [](const Observation&) {}).kind(),
            OutcomeKind::not_found);
}

/// Three axes in lock-step.
class CommandEach : public testing::Test {
 protected:
  std::vector<Outcome> command(EachCommand command, const CallOptions& call = {}) {
    return session_.command_each(axes_, command, call);
  }

  [[nodiscard]] std::uint64_t tick() const { return axes_.front().status()->tick; }

 private:
  test::BenchOnWire bench_{"--clock lockstep --axes 3"};

 protected:
  Session session_{options_on_wire()};
  std::vector<Axis> axes_ = *session_.axes(1);
};

TEST_F(CommandEach, TakesTheSameTicksForManyAxesAsForOne) {
  for (const EachCommand each : {EachCommand::enable, EachCommand::halt, EachCommand::resume,
                                 EachCommand::disable, EachCommand::quick_stop}) {
    const std::uint64_t start = tick();
    for (const Outcome& outcome : command(each, in_force())) {
      EXPECT_TRUE(outcome) << outcome.message();
    }
    EXPECT_EQ(tick(), start + 1) << static_cast<int>(each);
  }
  for (const Outcome& outcome : command(EachCommand::power_cycle)) {
    EXPECT_TRUE(outcome) << outcome.message();
  }
  for (const Axis& axis : axes_) EXPECT_EQ(axis.status()->state(), PowerState::switch_on_disabled);
}

// Enabled without a mode, as after power-on: bit 10 shows no target, and the axis is at rest.
TEST_F(CommandEach, HaltsAndResumesAxesWithoutAModeAtOnce) {
  command(EachCommand::enable);
  ASSERT_EQ(axes_.front().status()->mode(), OperatingMode::none);
  const std::uint64_t start = tick();
  for (const EachCommand each : {EachCommand::halt, EachCommand::resume}) {
    for (const Outcome& outcome : command(each)) EXPECT_TRUE(outcome) << outcome.message();
  }
  EXPECT_LT(tick(), start + 10);
  auto group = AxisGroup::create(session_, axes_).value();
  EXPECT_TRUE(group.halt_all());
  EXPECT_LT(tick(), start + 20);
}

// The second axis has a fault, the third belongs to another session.
TEST_F(CommandEach, GivesEveryAxisItsOwnOutcome) {
  ASSERT_TRUE(axes_[1].disturb(Disturbance::over_current));
  ASSERT_TRUE(session_.step(1, 2));
  Session other(options_on_wire());
  ASSERT_TRUE(other.axis("1.3")->enable());
  const std::vector<Outcome> outcomes = command(EachCommand::enable);
  ASSERT_EQ(outcomes.size(), 3U);
  EXPECT_TRUE(outcomes[0]) << outcomes[0].message();
  EXPECT_EQ(outcomes[1].code(), kRefusedInState);
  EXPECT_THAT(outcomes[1].message(), HasSubstr("axis 1.2 shows error 0x2310 "))
      << "the cause first";
  EXPECT_THAT(outcomes[1].message(), HasSubstr("; enabling needs a fault reset first"));
  EXPECT_EQ(outcomes[2].code(), wire_code(AbortCode::refused_local_control));
  EXPECT_THAT(outcomes[2].message(), HasSubstr("axis 1.3"));
  const std::vector<Outcome> resets = command(EachCommand::reset_fault);
  EXPECT_THAT(resets[1].message(), HasSubstr("the cause persists"));
  const std::vector<Outcome> halts = command(EachCommand::halt, in_force());
  EXPECT_TRUE(halts[0]) << halts[0].message();
  EXPECT_EQ(halts[1].code(), kRefusedInState);
  EXPECT_TRUE(halts[2]) << "stopping is always possible: " << halts[2].message();
}

// A frame has up to 256 axes. The second frame has an axis of another session, the third one has an
// axis with a fault.
TEST(CommandEachOfSixHundredAxes, TakesOneTickAndLeavesOutWhatRefuses) {
  const test::BenchOnWire bench("--clock lockstep --axes 600");
  Session session(options_on_wire());
  std::vector<Axis> axes = *session.axes(1);
  ASSERT_EQ(axes.size(), 600U);
  constexpr std::size_t kTaken = 299;
  constexpr std::size_t kFaulted = 598;
  ASSERT_TRUE(axes[kFaulted].disturb(Disturbance::over_current));
  ASSERT_TRUE(session.step(1, 2));
  Session other(options_on_wire());
  ASSERT_TRUE(other.axis("1.300")->acquire());
  for (const EachCommand each : {EachCommand::enable, EachCommand::resume, EachCommand::disable}) {
    const std::uint64_t start = axes.front().status()->tick;
    const std::vector<Outcome> outcomes = session.command_each(axes, each, in_force());
    ASSERT_EQ(outcomes.size(), axes.size());
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      EXPECT_EQ(static_cast<bool>(outcomes[i]), i != kTaken && i != kFaulted)
          << to_string(axes[i].id()) << ": " << outcomes[i].message();
    }
    EXPECT_EQ(axes.front().status()->tick, start + 1) << static_cast<int>(each);
  }
}

// At 2048 UU/s and 100 UU/s² the quick stop would take 20 s; all axes share one time-out.
TEST_F(CommandEach, HasOneTimeOutForAll) {
  constexpr ObjectAddress kQuickStopRamp{0x6085, 0};
  command(EachCommand::enable);
  for (Axis& axis : axes_) {
    ASSERT_TRUE(axis.run_at(2'048));
    ASSERT_TRUE(axis.write(kQuickStopRamp, 100));
  }
  const std::uint64_t start = tick();
  const std::vector<Outcome> outcomes = command(EachCommand::quick_stop, {.timeout = 500ms});
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    EXPECT_EQ(outcomes[i].kind(), OutcomeKind::timed_out);
    EXPECT_THAT(outcomes[i].message(), HasSubstr("axis " + to_string(axes_[i].id())));
  }
  EXPECT_LT(tick(), start + 600);
}

}  // namespace
}  // namespace vdrive::client
