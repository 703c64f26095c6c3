// SPDX-License-Identifier: Apache-2.0
// Scenarios: `finally` lines and several files; `wait` and `expect` on the command line.
#include "support/bench_on_wire.hpp"
#include "support/temporary_directory.hpp"
#include "tool/call.hpp"
#include "tool/json_lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <sstream>
#include <string>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kPatient =
    "--clock realtime --axes 2 --config " VDRIVE_SOURCE_DIR "/tests/data/patient.yaml";

Json status_of(const std::string& axis) {
  return Json::parse(call("status " + axis + " --json").output);
}

class FinalLines : public testing::Test {
 protected:
  BenchOnWire bench_{"--clock lockstep"};
};

TEST_F(FinalLines, RunAfterSuccess) {
  const Finished finished = call("run -", "enable 1.1\nfinally\ndisable 1.1\n");
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output, HasSubstr("2 lines"));
  EXPECT_EQ(status_of("1.1")["state"], "Ready to switch on");
}

TEST_F(FinalLines, RunAfterAFailureAndKeepItsExitCode) {
  const Finished finished = call("run -",
                                 "enable 1.1\n"
                                 "expect 1.1 position > 100\n"
                                 "move 1.1 500\n"
                                 "finally\n"
                                 "enable 1.9 --timeout 0.1\n"
                                 "disable 1.1\n");
  EXPECT_EQ(finished.code, 3) << "axes of final lines are searched first";
  const Finished failed = call("run -",
                               "enable 1.1\n"
                               "expect 1.1 position > 100\n"
                               "move 1.1 500\n"
                               "finally\n"
                               "expect 1.1 mode 99 --tolerance 1\n"
                               "disable 1.1\n");
  EXPECT_EQ(failed.code, 1);
  EXPECT_THAT(failed.errors,
              AllOf(HasSubstr("<stdin>:2: "),
                    HasSubstr("expected > 100 UU (8.79 deg), actual 0 UU (0.00 deg)"),
                    HasSubstr("<stdin>:5: ")));
  EXPECT_EQ(status_of("1.1")["state"], "Ready to switch on") << "also after a final line failed";
  EXPECT_EQ(status_of("1.1")["position_demand_value"], 0) << "the move was skipped";
}

TEST(Clock, IsRestoredWhenAScenarioFails) {
  const BenchOnWire bench(kPatient);
  const Finished finished = call("run -", "rate 5\nrate 2\nexpect 1.1 position 1\n");
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, HasSubstr("restored: rate of bench 1 is 1"));
  EXPECT_EQ(call("rate").output, "bench 1 realtime rate 1\n");
  EXPECT_EQ(call("run -", "rate 2\n").code, 0);
  EXPECT_EQ(call("rate").output, "bench 1 realtime rate 2\n") << "a success changes what it sets";
}

/// Several scenario files.
class SeveralFiles : public testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& lines) {
    const std::string path = directory_.path() / name;
    std::ofstream(path) << lines;
    return path;
  }

  std::string report() {
    std::ifstream file(directory_.path() / "out.xml");
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }

  Finished run(std::vector<std::string> files) {
    files.insert(files.begin(), {"run", "--junit", directory_.path() / "out.xml"});
    return call(std::move(files));
  }

  TemporaryDirectory directory_;
  BenchOnWire bench_{"--clock lockstep"};
};

TEST_F(SeveralFiles, RunOneAfterTheOtherWithOneReport) {
  const Finished finished =
      run({file("a.scn", "enable 1.1\n"), file("b.scn", "expect 1.1 mode 9\n"),
           file("c.scn", "expect 1.1 statusword 0x637 --mask 0x6f\n")});
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, AllOf(HasSubstr("b.scn:1: "), HasSubstr("2 of 3 files passed")));
  EXPECT_THAT(report(), AllOf(HasSubstr("<testsuites tests=\"3\" failures=\"1\""),
                              HasSubstr("a.scn\" tests=\"1\" failures=\"0\""),
                              HasSubstr("b.scn\" tests=\"1\" failures=\"1\"")));
}

TEST_F(SeveralFiles, AreAllCheckedBeforeTheFirstCommand) {
  const std::string good = file("a.scn", "enable 1.1\n");
  EXPECT_EQ(run({good, file("b.scn", "enabel 1.1\n")}).code, 2);
  EXPECT_EQ(run({good, file("b.scn", "enable 1.9\n")}).code, 3);
  EXPECT_THAT(report(), AllOf(HasSubstr("errors=\"1\""), HasSubstr("skipped=\"1\"")));
  EXPECT_EQ(run({good, "/nonexistent.scn"}).code, 2);
  EXPECT_EQ(run({good, file("b.scn", "# to be written\n")}).code, 2);
  EXPECT_EQ(status_of("1.1")["state"], "Switch on disabled");
}

// Eleven mistakes in two files, none of which can be seen in the text alone.
TEST_F(SeveralFiles, NameEveryAxisAndBenchThatIsNotThere) {
  const std::string one = file("a.scn",
                               "enable 1.1\nenable 1.9\nread lft 0x6041\nstep 1 --bench 8\n"
                               "enable 7.1\nenable 1.9\nwait lft fault\nenable 7.2\n");
  const std::string two =
      file("b.scn", "enable 1.8\nenable 1.9\nenable 1.2 9.1\nread lft 0x6041\n");
  const Finished finished = run({one, two});
  EXPECT_EQ(finished.code, 3);
  for (const int line : {2, 3, 4, 5, 6, 7, 8}) {
    EXPECT_THAT(finished.errors, HasSubstr("a.scn:" + std::to_string(line) + ": no "));
  }
  for (const int line : {1, 2, 3, 4}) {
    EXPECT_THAT(finished.errors, HasSubstr("b.scn:" + std::to_string(line) + ": no "));
  }
  EXPECT_THAT(finished.errors, Not(HasSubstr("a.scn:1: ")));
  EXPECT_THAT(finished.errors, HasSubstr("a.scn:8: no axis 7.2: no bench 7"));
  EXPECT_THAT(report(), HasSubstr("errors=\"2\""));
}

TEST_F(SeveralFiles, NameEveryMistakeOfAllOfThem) {
  const std::string one = file("a.scn", "dance\nenable 1.1\nmove 1.1 fast\n");
  const std::string two = file("b.scn", "read 1.1 0x9999\n");
  const Finished finished = run({one, two});
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors,
              AllOf(HasSubstr("a.scn:1: "), HasSubstr("a.scn:3: "), HasSubstr("b.scn:1: ")));
}

TEST_F(SeveralFiles, ShareTheVariablesOfTheCommandLine) {
  const std::string one = file("a.scn", "let axis = 1.1\nenable ${axis}\n");
  const std::string two = file("b.scn", "let target = 1\nexpect 1.2 statusword 0x27 --mask 0x6f\n");
  EXPECT_EQ(call({"run", one, two, "--set", "axis=1.2"}).code, 0);
  const Finished unknown = call({"run", one, two, "--set", "axes=1.2"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.errors, HasSubstr("no file has a variable 'axes' (did you mean 'axis'?)"));
}

// The second of four lines fails; the last one is below `finally`. The axis is enabled, at 0.
TEST_F(SeveralFiles, ReportTheTickTheAxisAndTheNextStepOfAFailure) {
  const std::string failing =
      file("a.scn", "enable 1.1\nexpect 1.1 statusword 8 --mask 8\nmove 1.1 5\nfinally\nstep 1\n");
  const Finished finished = run({failing});
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.output, HasSubstr("failed  " + failing + ", 3 of 4 lines done"));
  EXPECT_THAT(finished.errors,
              AllOf(HasSubstr("a.scn:2: expect 1.1 statusword 8 --mask 8: statusword: "
                              "expected 0x008 (8) under mask 0x00000008, actual 0x"),
                    HasSubstr(": Operation enabled, bit 3 fault is 0\n"),
                    testing::ContainsRegex("\n  axis 1.1 at tick [0-9]+: 0x[0-9A-F]+ Operation "
                                           "enabled.*; position 0 UU \\(0.00 deg\\), velocity"),
                    HasSubstr("\n  next: add --within if the value is reached later")));
  EXPECT_THAT(report(),
              AllOf(HasSubstr("file=\"" + failing + "\" line=\"2\"><failure message="),
                    HasSubstr("type=\"expectation\">" + failing + ":2: expect"),
                    HasSubstr("\n  next: add --within"), HasSubstr("line=\"3\"><skipped/>")));
}

struct AdviceRow {
  const char* name;
  const char* lines;
  const char* advice;
};

class AdviceOfAFailure : public testing::TestWithParam<AdviceRow> {
 protected:
  BenchOnWire bench_{"--clock lockstep"};
};

TEST_P(AdviceOfAFailure, IsTheNextStep) {
  const Finished finished = call("run - --json", GetParam().lines);
  EXPECT_EQ(finished.code, 1) << finished.errors;
  EXPECT_THAT(finished.errors, HasSubstr(std::string("  next: ") + GetParam().advice));
  const std::vector<std::string> lines = finished.lines();
  ASSERT_GE(lines.size(), 2U);
  const Json failed = Json::parse(lines[lines.size() - 2]);
  EXPECT_TRUE(failed.contains("tick")) << failed;
  EXPECT_THAT(failed["advice"].get<std::string>(), testing::StartsWith(GetParam().advice));
  EXPECT_THAT(failed["details"][0].get<std::string>(), testing::StartsWith("axis 1.1 at tick "));
}

INSTANTIATE_TEST_SUITE_P(
    Lines, AdviceOfAFailure,
    testing::Values(
        AdviceRow{"not_enabled", "move 1.1 100\n", "write 'enable 1.1' above this line"},
        AdviceRow{"in_fault", "disturb 1.1 over_temperature\nwait 1.1 fault\nmove 1.1 5\n",
                  "'vdrive events 1.1' shows the cause of the fault; 'reset 1.1' above"},
        AdviceRow{"refused", "store 1.1\n",  // the bench has no state directory
                  "change the command, or write 'refused 0x08000020' in front"},
        AdviceRow{"not_refused", "enable 1.1\nrefused 0x08000022 move 1.1 5\n",
                  "remove 'refused' from this line"},
        AdviceRow{"moving",
                  "enable 1.1\nmove 1.1 100000 --velocity 1000 --no-wait\nexpect 1.1 position 9\n",
                  "the axis is moving: write 'wait 1.1 target_reached'"},
        AdviceRow{"too_slow", "enable 1.1\nmove 1.1 100000 --velocity 100 --timeout 1\n",
                  "the axis is moving: allow more time with --timeout"},
        AdviceRow{"still", "enable 1.1\nwait 1.1 position 5 --timeout 10ms\n",
                  "the axis is at standstill: its statusword shows"},
        AdviceRow{"of_the_axes_before", "enable 1.1\nrate 0.5\n", ""}),
    [](const auto& row) {
      return row.param.name;
    });

class WaitAndExpect : public testing::Test {
 protected:
  BenchOnWire bench_{"--clock lockstep"};
};

TEST_F(WaitAndExpect, PassOrReportTheValuesOfTheAxis) {
  EXPECT_EQ(call("wait 1.1 switch_on_disabled").code, 0);
  EXPECT_EQ(call("expect 1.1 position 0").code, 0);
  EXPECT_EQ(call("expect 1.1 position < 1 --within 1ms").code, 0);
  const Finished other = call("expect 1.1 position != 0");
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.errors,
              HasSubstr("position: expected != 0 UU (0.00 deg), actual 0 UU (0.00 deg) at tick"));
  const Finished never = call("wait 1.1 operation_enabled --timeout 50ms");
  EXPECT_EQ(never.code, 4);
  EXPECT_THAT(never.errors, AllOf(HasSubstr("axis 1.1: timed out while waiting for"),
                                  HasSubstr("operation_enabled, shows 0x250 Switch on disabled")));
  EXPECT_EQ(call("wait 1.1 position > 5 --timeout 50ms").code, 4);
  EXPECT_EQ(call("expect 1.1 position 5 --within 50ms").code, 1);
  const Finished refused = call("wait 1.1 no_such_object 5");
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(call("wait 1.1 target_reachd").errors, HasSubstr("did you mean 'target_reached'?"));
}

/// The drive time of the bench, in ticks of 1 ms.
std::uint64_t tick_now() {
  return nlohmann::json::parse(call("status 1.1 --json").output).at("tick").get<std::uint64_t>();
}

/// The tick of the last fault of axis 1.1, according to its event.
std::string tick_of_last_fault() {
  std::string tick;
  for (const std::string& line : call("events 1.1 --json").lines()) {
    const Json event = Json::parse(line);
    if (event["kind"].get<std::string>() == "fault") tick = event["tick"].dump();
  }
  return tick;
}

// 4310h disables the axis immediately. After 100 ms at rest, the condition can no longer come true.
TEST_F(WaitAndExpect, EndAtOnceOnAnAxisThatStaysInFault) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  ASSERT_EQ(call("disturb 1.1 over_temperature").code, 0);
  ASSERT_EQ(call("wait 1.1 fault").code, 0);
  ASSERT_EQ(call("step 1000").code, 0);
  const std::string since = ", since tick " + tick_of_last_fault() + "; waited for ";
  const std::uint64_t before = tick_now();
  const Finished waited = call("wait 1.1 target_reached --timeout 30s");
  EXPECT_EQ(waited.code, 1);
  EXPECT_THAT(waited.errors,
              AllOf(HasSubstr("axis 1.1 is in Fault 0x4310"), HasSubstr(since + "target_reached"),
                    HasSubstr("; reset it first: vdrive reset 1.1")));
  const Finished value = call("expect 1.1 position 1000 --within 30s --json");
  EXPECT_EQ(value.code, 1);
  EXPECT_THAT(value.output, AllOf(HasSubstr("\"actual\":0"), HasSubstr("\"error_code\":17168")));
  EXPECT_EQ(call("expect 1.1 statusword 0x637 --within 30s").code, 1);
  EXPECT_EQ(call("wait 1.1 position 1000 --timeout 30s").code, 1);
  EXPECT_EQ(call("expect 1.1 torque 50 --within 30s").code, 1);
  const Finished mode = call("expect 1.1 mode 5 --within 30s");
  EXPECT_EQ(mode.code, 1);
  EXPECT_THAT(mode.errors,
              AllOf(HasSubstr("axis 1.1 is in Fault 0x4310"), HasSubstr(since + "mode 5")));
  EXPECT_EQ(call("expect 1.1 statusword 0x400 --mask 0x400 --within 30s").code, 1);
  EXPECT_EQ(call("expect 1.1 statusword 0x1000 --mask 0x1000 --within 30s").code, 1);
  EXPECT_LE(tick_now() - before, 8 * 110) << "each of the eight ended after 100 ms";
}

TEST_F(WaitAndExpect, GoOnInFaultForWhatTheFaultOrAResetBrings) {
  ASSERT_EQ(call("disturb 1.1 over_temperature").code, 0);
  EXPECT_EQ(call("wait 1.1 fault --timeout 1s").code, 0);
  EXPECT_EQ(call("wait 1.1 switch_on_disabled --timeout 300ms").code, 4);
  EXPECT_EQ(call("wait 1.1 internal_limit_active --timeout 300ms").code, 4);
  EXPECT_EQ(call("wait 1.1 statusword 0x40 --timeout 300ms").code, 4);
  const Finished parameter = call("wait 1.1 profile_velocity 7 --timeout 300ms");
  EXPECT_EQ(parameter.code, 4) << "another program may still write it";
  EXPECT_THAT(parameter.errors,
              AllOf(HasSubstr("profile_velocity: expected 7 UU/s (0.62 deg/s), actual "),
                    HasSubstr("; axis 1.1 is in Fault 0x4310"),
                    HasSubstr(", since tick " + tick_of_last_fault() + "\n")));
}

TEST_F(WaitAndExpect, NameTheFaultOfAMotionFirst) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  ASSERT_EQ(call("disturb 1.1 blocked_load").code, 0);
  const Finished moved = call("move 1.1 100000");
  EXPECT_EQ(moved.code, 1);
  EXPECT_THAT(moved.errors, AllOf(HasSubstr("axis 1.1 shows error 0x8611 following error, "),
                                  HasSubstr("; waited for target reached, bit 10"),
                                  HasSubstr("; reset it first: vdrive reset 1.1")));
  for (const char* const words : {"velocity 1.1 100", "enable 1.1", "move 1.1 5"}) {
    const Finished refused = call(words);
    EXPECT_EQ(refused.code, 5) << words;
    EXPECT_THAT(refused.errors, AllOf(HasSubstr("axis 1.1 shows error 0x8611 following error, "),
                                      HasSubstr("; reset it first: vdrive reset 1.1")))
        << words;
  }
}

TEST_F(WaitAndExpect, ObserveAMotionThatAnotherProgramStarted) {
  ASSERT_EQ(call("enable 1.1").code, 0);
  ASSERT_EQ(call("move 1.1 1000 --velocity 1000 --no-wait").code, 0);
  EXPECT_EQ(call("wait 1.1 position > 500").code, 0);
  const Finished arrived = call("wait 1.1 target_reached --timeout 5s --json");
  EXPECT_EQ(arrived.code, 0) << arrived.errors;
  EXPECT_THAT(arrived.output, AllOf(HasSubstr("\"command\":\"wait\""), HasSubstr("Operation")));
  const Finished same = call("expect 1.1 position 1000 --tolerance 1 --within 1s --json");
  EXPECT_EQ(same.code, 0) << same.errors;
  EXPECT_THAT(same.output, HasSubstr("\"comparison\":\"==\",\"expected\":1000"));
  EXPECT_THAT(call("wait 20ms").output, HasSubstr("bench 1 tick "));
}

}  // namespace
}  // namespace vdrive::test
