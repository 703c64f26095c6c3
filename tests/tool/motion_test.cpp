// SPDX-License-Identifier: Apache-2.0
// home, velocity, torque, jog, and commands for several axes.
#include "support/bench_on_wire.hpp"
#include "support/temporary_directory.hpp"
#include "tool/call.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <string>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;
using testing::StartsWith;

std::string value_of(const std::string& axis, const std::string& object) {
  return nlohmann::json::parse(call("read " + axis + " " + object + " --json").output)["value"]
      .dump();
}

class MotionInLockStep : public testing::Test {
 protected:
  BenchOnWire bench_{"--clock lockstep --axes 3"};
};

TEST_F(MotionInLockStep, HomeSetsTheHomePositionAndReportsAHomingError) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished homed = call("home 1.1 --method 37 --offset -90deg");
  ASSERT_EQ(homed.code, 0) << homed.errors;
  EXPECT_THAT(homed.output, HasSubstr("homing attained"));
  EXPECT_EQ(value_of("1.1", "0x6062"), "-1024");
  const Finished failed = call("home 1.1 --method 0");
  EXPECT_EQ(failed.code, 1);
  EXPECT_THAT(failed.errors, HasSubstr("homing error, bit 13, with homing_method (6098h) = 0"));
  EXPECT_EQ(call("home 1.2").code, 5) << "not enabled";
}

// 180 deg/s are 2048 UU/s.
TEST_F(MotionInLockStep, VelocityRunsUntilAVelocityOfZero) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished runs = call("velocity 1.1 180deg/s");
  ASSERT_EQ(runs.code, 0) << runs.errors;
  EXPECT_EQ(value_of("1.1", "0x606B"), "2048");
  ASSERT_EQ(call("velocity 1.1 0").code, 0);
  EXPECT_EQ(value_of("1.1", "0x606B"), "0");
}

// An earlier program has ended and left its 60FFh and mode.
TEST_F(MotionInLockStep, EnableLetsAnAxisRestUnlessItIsToKeepItsTarget) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  ASSERT_EQ(call("velocity 1.1 2048").code, 0);
  ASSERT_EQ(call("quick-stop 1.1").code, 0);
  EXPECT_EQ(value_of("1.1", "0x60FF"), "2048");
  ASSERT_EQ(call("enable 1.1").code, 0);
  EXPECT_EQ(value_of("1.1", "0x60FF"), "0");
  ASSERT_EQ(call("step 300").code, 0);
  EXPECT_EQ(value_of("1.1", "0x606B"), "0");
  ASSERT_EQ(call("disable 1.1").code, 0);
  ASSERT_EQ(call("write 1.1 0x60FF 2048").code, 0);
  ASSERT_EQ(call("enable 1.1 --keep-target").code, 0);
  ASSERT_EQ(call("step 300").code, 0);
  EXPECT_EQ(value_of("1.1", "0x606B"), "2048");
  EXPECT_EQ(call("disable 1.1 --keep-target").code, 2) << "it is of enable only";
}

TEST_F(MotionInLockStep, TorqueIsAppliedInPercent) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished applied = call("torque 1.1 3% --slope 1000");
  ASSERT_EQ(applied.code, 0) << applied.errors;
  EXPECT_EQ(value_of("1.1", "0x6074"), "30");
}

TEST_F(MotionInLockStep, JogForATimeStopsAfterIt) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished jogged = call("jog 1.1 10000 --for 100ms --json");
  ASSERT_EQ(jogged.code, 0) << jogged.errors;
  EXPECT_EQ(value_of("1.1", "0x60FF"), "0");
  EXPECT_EQ(value_of("1.1", "0x606B"), "0");
  EXPECT_GT(nlohmann::json::parse(jogged.output)["position"], 500);
}

// 100,000 UU at 100 UU/s take 1000 s; the time-out ends 1 s of it.
TEST_F(MotionInLockStep, ATimeoutSaysWhereTheAxisIsAndThatItGoesOn) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished late = call("move 1.1 100000 --velocity 100 --timeout 1s");
  EXPECT_EQ(late.code, 4);
  EXPECT_THAT(
      late.errors,
      AllOf(HasSubstr(
                " of 100000 UU (8789.06 deg), still moving at 100 UU/s (8.79 deg/s), about 1000 s "
                "left"),
            HasSubstr("; to stop it: vdrive halt 1.1")));
  EXPECT_EQ(call("halt 1.1").code, 0);
}

// At 1000 UU/s² the velocity is reached after 100 s. If the tool only released the axis, nothing
// would stop it; if it ended while owning it, the axis would stop with fault 8130h after 500 ms.
TEST_F(MotionInLockStep, AVelocityThatTakesTooLongSaysHowFarItCameAndHaltsTheAxis) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished late = call("velocity 1.1 100000 --acceleration 1000 --timeout 1s");
  EXPECT_EQ(late.code, 4);
  EXPECT_THAT(late.errors, AllOf(HasSubstr(" of 100000 UU/s (8789.06 deg/s), still changing"),
                                 HasSubstr("; axis 1.1 is halted")));
  EXPECT_EQ(value_of("1.1", "0x606B"), "0");
  ASSERT_EQ(call("step 1000").code, 0);
  EXPECT_EQ(value_of("1.1", "0x603F"), "0");
  EXPECT_THAT(call("status 1.1 --json").output, HasSubstr("\"owner\":null"));
}

TEST_F(MotionInLockStep, ATorqueThatTakesTooLongSaysHowFarItCameAndHaltsTheAxis) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished late = call("torque 1.1 100 --slope 10 --timeout 2s");
  EXPECT_EQ(late.code, 4);
  EXPECT_THAT(late.errors, AllOf(HasSubstr(" of 100 per mille of rated torque, still changing"),
                                 HasSubstr("; axis 1.1 is halted")));
  EXPECT_EQ(value_of("1.1", "0x606B"), "0");
  ASSERT_EQ(call("step 1000").code, 0);
  EXPECT_EQ(value_of("1.1", "0x603F"), "0");
}

// There is no switch to find, so homing continues after the command.
TEST_F(MotionInLockStep, AHomingRunThatTakesTooLongSaysHowToStopIt) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished late = call("home 1.1 --method 17 --speed 100 --creep 100 --timeout 1s");
  EXPECT_EQ(late.code, 4);
  EXPECT_THAT(late.errors, AllOf(HasSubstr(" deg), still moving at -100 UU/s (-8.79 deg/s)"),
                                 HasSubstr("; to stop it: vdrive halt 1.1")));
  EXPECT_EQ(call("halt 1.1").code, 0);
}

TEST_F(MotionInLockStep, ALimitThatClampsIsReportedAtOnce) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished fast = call("velocity 1.1 140000");
  EXPECT_EQ(fast.code, 5);
  EXPECT_THAT(fast.errors, HasSubstr("is above app_speed_limit (607Fh) = 136533"));
  const Finished move = call("move 1.1 1000 --velocity 1e6");
  EXPECT_EQ(move.code, 5);
  EXPECT_THAT(move.errors,
              AllOf(HasSubstr("the velocity 1000000 UU/s (87890.6"),
                    HasSubstr(" is above app_speed_limit (607Fh) = 136533 UU/s (11999.97 deg/s)")));
  const Finished home = call("home 1.1 --method 17 --speed 1e6");
  EXPECT_EQ(home.code, 5);
  EXPECT_THAT(home.errors, HasSubstr("the homing_speed_search (6099h:1) 1000000 UU/s (87890.62 "
                                     "deg/s) is above app_speed_limit (607Fh) = 136533 UU/s"));
  const Finished strong = call("torque 1.1 3001");
  EXPECT_EQ(strong.code, 5);
  EXPECT_THAT(strong.errors, HasSubstr("is above max_torque (6072h) = 3000"));
  ASSERT_EQ(call("disturb 1.1 positive_limit").code, 0);
  const Finished moved = call("move 1.1 1000");
  EXPECT_EQ(moved.code, 1);
  EXPECT_THAT(moved.errors, HasSubstr("the positive limit switch (60FDh bit 1) ended"));
}

TEST_F(MotionInLockStep, TheCommandsAreAcceptedInAScenario) {
  const TemporaryDirectory directory;
  const std::string file = (directory.path() / "modes.scn").string();
  std::ofstream(file) << "enable 1.*\nhome 1.1 --method 35\nvelocity 1.1 90deg/s\n"
                         "expect 1.1 velocity_demand_value 1024\nvelocity 1.1 0\n"
                         "jog 1.2 1000 --for 20ms\ntorque 1.3 10\n";
  const Finished passed = call("run " + file);
  EXPECT_EQ(passed.code, 0) << passed.errors;
}

TEST_F(MotionInLockStep, OneCommandAcceptsSeveralAxes) {
  const Finished some = call("enable 1.1 axis3 1.1");
  ASSERT_EQ(some.code, 0) << some.errors;
  EXPECT_THAT(some.lines(), ElementsAre(StartsWith("1.1 "), StartsWith("axis3 ")));
  const Finished rest = call("enable 1.*");
  ASSERT_EQ(rest.code, 0) << rest.errors;
  EXPECT_THAT(rest.lines(), SizeIs(3));
  EXPECT_THAT(call("quick-stop --all").lines(), SizeIs(3));
  EXPECT_EQ(call("status 1.axis2").code, 0);
}

TEST_F(MotionInLockStep, AFailingAxisDoesNotPreventTheOthers) {
  ASSERT_EQ(call("disturb 1.2 over_current").code, 0);
  ASSERT_EQ(call("step 2").code, 0);
  const Finished mixed = call("enable 1.*");
  EXPECT_EQ(mixed.code, 5);
  EXPECT_THAT(mixed.errors, AllOf(HasSubstr("axis 1.2"), HasSubstr("vdrive reset 1.2")));
  EXPECT_THAT(mixed.lines(), ElementsAre(StartsWith("1.1 "), StartsWith("1.3 ")));
}

TEST(ManyAxes, TakeAsManyTicksAsOne) {
  const BenchOnWire bench("--clock lockstep --axes 64");
  const auto tick = [] {
    return nlohmann::json::parse(call("status 1.1 --json").output)["tick"].get<int>();
  };
  for (const char* const word : {"enable", "halt", "resume", "quick-stop --no-wait"}) {
    const int before = tick();
    const Finished finished = call(std::string(word) + " --all");
    EXPECT_EQ(finished.code, 0) << word << ": " << finished.errors;
    EXPECT_THAT(finished.lines(), SizeIs(64)) << word;
    EXPECT_EQ(tick(), before + 1) << word;
  }
}

TEST(ManyAxes, ReportTheLossOfTheirBenchOnce) {
  const BenchOnWire bench("--rate 0 --axes 3");
  const Finished paused = call("enable --all");
  EXPECT_EQ(paused.code, 1);
  EXPECT_THAT(paused.lines(), SizeIs(0));
  EXPECT_EQ(std::ranges::count(paused.errors, '\n'), 1) << paused.errors;
}

TEST_F(MotionInLockStep, StatusWithoutAnAxisShowsEveryAxisOnALine) {
  const Finished status = call("status");
  ASSERT_EQ(status.code, 0) << status.errors;
  EXPECT_THAT(status.lines(), ElementsAre(AllOf(StartsWith("1.1 "), HasSubstr("axis1")),
                                          AllOf(StartsWith("1.2 "), HasSubstr("axis2")),
                                          AllOf(StartsWith("1.3 "), HasSubstr("axis3"))));
  EXPECT_THAT(call("status --json").lines(), SizeIs(3));
}

TEST_F(MotionInLockStep, AnUnknownAxisNameGetsASuggestion) {
  const Finished missing = call("status 1.axs2");
  EXPECT_EQ(missing.code, 3);
  EXPECT_THAT(missing.errors, HasSubstr("did you mean 'axis2'?"));
  EXPECT_EQ(call("enable 9.* --timeout 0.2").code, 3);
  EXPECT_THAT(call("enable axis*").errors, HasSubstr("'7.*'"));
}

TEST(SeveralBenches, CanShareTheNameOfAnAxis) {
  const BenchOnWire first("--clock lockstep --bench 1");
  const BenchOnWire second("--clock lockstep --bench 2");
  const Finished one = call("status 2.x");
  ASSERT_EQ(one.code, 0) << one.errors;
  EXPECT_THAT(one.output, StartsWith("2.1 x"));
  EXPECT_THAT(call("enable --all").lines(), SizeIs(4));
}

TEST(Jog, EndsAtTheEndOfStandardInput) {
  const BenchOnWire bench("--clock lockstep");
  ASSERT_EQ(call("enable 1.1").code, 0);
  const Finished jogged = call("jog 1.1 10000", "\n");
  EXPECT_EQ(jogged.code, 0) << jogged.errors;
  EXPECT_THAT(jogged.errors, HasSubstr("Enter or Ctrl-C stops the axis"));
  EXPECT_EQ(value_of("1.1", "0x60FF"), "0");
}

}  // namespace
}  // namespace vdrive::test
