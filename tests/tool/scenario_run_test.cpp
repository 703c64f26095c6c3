// SPDX-License-Identifier: Apache-2.0
// Scenarios against the real service: what ends a wait, final lines, several files; and `wait` and
// `expect` on the command line.
#include "support/temporary_directory.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <fstream>
#include <sstream>
#include <string>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

using Json = nlohmann::ordered_json;

constexpr const char* kPatient =
    "--clock realtime --axes 2 --config " VDRIVE_SOURCE_DIR "/tests/data/patient.yaml";

Json status_of(const std::string& axis) {
  return Json::parse(tool("status " + axis + " --json").output);
}

/// A scenario from standard input whose last line waits for a condition that never holds.
class WaitingScenario {
 public:
  /// @param lines each of one output line; the last one waits
  explicit WaitingScenario(const std::string& lines)
      : process_(VDRIVE_TOOL, tool_arguments("run - --json"), "enable 1.1\n" + lines) {
    (void)process_.read_line();  // of enable
  }

  void send(int signal) const { process_.send(signal); }

  Finished wait() { return process_.wait(); }

 private:
  Process process_;
};

constexpr const char* kNeverReached = "expect 1.1 position 1000 --within 100s\n";

TEST(WaitingExpect, EndsAtOnceWhenAnotherSessionTakesItsAxis) {
  const RunningService service(kPatient);
  WaitingScenario scenario(kNeverReached);
  EXPECT_EQ(tool("enable 1.1 --take-over").code, 0);
  const Finished finished = scenario.wait();
  EXPECT_EQ(finished.code, 1);
  EXPECT_LT(finished.duration, 60s);
  EXPECT_THAT(finished.errors, HasSubstr("axis 1.1 was lost: "));
  EXPECT_THAT(finished.output, HasSubstr("\"outcome\":\"lost\""));
}

TEST(WaitingExpect, EndsAtOnceWhenItsServiceEnds) {
  RunningService service(kPatient);
  WaitingScenario scenario(kNeverReached);
  service.kill();
  const Finished finished = scenario.wait();
  EXPECT_EQ(finished.code, 1);
  EXPECT_LT(finished.duration, 60s);
  EXPECT_THAT(finished.errors, HasSubstr("bench 1 stopped sending or ended"));
}

TEST(WaitingExpect, EndsAtOnceWhenItsServiceRestarts) {
  RunningService service(kPatient);
  WaitingScenario scenario("expect 1.1 position 0 --throughout 100s\n");
  service.kill();
  const RunningService again(kPatient);
  const Finished finished = scenario.wait();
  EXPECT_EQ(finished.code, 1);
  EXPECT_LT(finished.duration, 60s);
  EXPECT_THAT(finished.errors, HasSubstr("bench 1 "));
}

// The bench receives nothing from a stopped program and releases its axis.
TEST(WaitingExpect, EndsWhenTheWatchdogTakesItsAxis) {
  const RunningService service("--clock realtime --axes 2");
  client::SessionOptions options;
  options.domain = test_domain();
  options.find_timeout = 20s;
  client::Session session(options);
  const auto axis = session.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  WaitingScenario scenario(kNeverReached);
  scenario.send(SIGSTOP);
  const auto taken = axis->wait_until(
      [](const client::AxisSnapshot& seen) {
        return seen.status.error_code == 0x8130;
      },
      60s);
  scenario.send(SIGCONT);
  ASSERT_TRUE(taken) << taken.outcome().message();
  const Finished finished = scenario.wait();
  EXPECT_EQ(finished.code, 1);
  EXPECT_LT(finished.duration, 100s);
  EXPECT_THAT(finished.errors, AllOf(HasSubstr("axis 1.1 was lost: "), HasSubstr("0x8130")));
  EXPECT_THAT(finished.output, HasSubstr("\"outcome\":\"lost\""));
}

class FinalLines : public testing::Test {
 protected:
  RunningService service_{"--clock lockstep"};
};

TEST_F(FinalLines, RunAfterSuccess) {
  const Finished finished = tool("run -", "enable 1.1\nfinally\ndisable 1.1\n");
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output, HasSubstr("2 lines"));
  EXPECT_EQ(status_of("1.1")["state"], "Ready to switch on");
}

TEST_F(FinalLines, RunAfterAFailureAndKeepItsExitCode) {
  const Finished finished = tool("run -",
                                 "enable 1.1\n"
                                 "expect 1.1 position > 100\n"
                                 "move 1.1 500\n"
                                 "finally\n"
                                 "enable 1.9 --timeout 0.1\n"
                                 "disable 1.1\n");
  EXPECT_EQ(finished.code, 3) << "axes of final lines are searched first";
  const Finished failed = tool("run -",
                               "enable 1.1\n"
                               "expect 1.1 position > 100\n"
                               "move 1.1 500\n"
                               "finally\n"
                               "expect 1.1 mode 99 --tolerance 1\n"
                               "disable 1.1\n");
  EXPECT_EQ(failed.code, 1);
  EXPECT_THAT(failed.errors, AllOf(HasSubstr("<stdin>:2: "), HasSubstr("expected > 100, actual 0"),
                                   HasSubstr("<stdin>:5: ")));
  EXPECT_EQ(status_of("1.1")["state"], "Ready to switch on") << "also after a final line failed";
  EXPECT_EQ(status_of("1.1")["position_demand_value"], 0) << "the move was skipped";
}

TEST_F(FinalLines, RunAfterAnInterrupt) {
  ASSERT_EQ(tool("enable 1.1").code, 0);
  Process run(VDRIVE_TOOL, tool_arguments("run - --json"),
              "step 1\n"
              "move 1.1 1000000 --velocity 1 --timeout 3600000\n"
              "finally\n"
              "disable 1.1\n");
  EXPECT_THAT(run.read_line(), HasSubstr("step 1"));
  run.send(SIGINT);
  EXPECT_EQ(run.wait().code, 130);
  EXPECT_EQ(status_of("1.1")["state"], "Ready to switch on");
}

TEST(Clock, IsRestoredWhenAScenarioFails) {
  const RunningService service(kPatient);
  const Finished finished = tool("run -", "rate 5\nrate 2\nexpect 1.1 position 1\n");
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, HasSubstr("restored: rate of bench 1 is 1"));
  EXPECT_EQ(tool("rate").output, "bench 1 realtime rate 1\n");
  EXPECT_EQ(tool("run -", "rate 2\n").code, 0);
  EXPECT_EQ(tool("rate").output, "bench 1 realtime rate 2\n") << "a success changes what it sets";
}

/// Files of scenarios.
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
    return tool(std::move(files));
  }

  TemporaryDirectory directory_;
  RunningService service_{"--clock lockstep"};
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
  EXPECT_EQ(status_of("1.1")["state"], "Switch on disabled");
}

TEST_F(SeveralFiles, ShareTheVariablesOfTheCommandLine) {
  const std::string one = file("a.scn", "let axis = 1.1\nenable ${axis}\n");
  const std::string two = file("b.scn", "let target = 1\nexpect 1.2 statusword 0x27 --mask 0x6f\n");
  EXPECT_EQ(tool({"run", one, two, "--set", "axis=1.2"}).code, 0);
  const Finished unknown = tool({"run", one, two, "--set", "axes=1.2"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.errors, HasSubstr("no file has a variable 'axes' (did you mean 'axis'?)"));
}

class WaitAndExpect : public testing::Test {
 protected:
  RunningService service_{"--clock lockstep"};
};

TEST_F(WaitAndExpect, PassOrReportTheValuesOfTheAxis) {
  EXPECT_EQ(tool("wait 1.1 switch_on_disabled").code, 0);
  EXPECT_EQ(tool("expect 1.1 position 0").code, 0);
  EXPECT_EQ(tool("expect 1.1 position < 1 --within 1ms").code, 0);
  const Finished other = tool("expect 1.1 position != 0");
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.errors, HasSubstr("position: expected != 0, actual 0 at tick"));
  const Finished never = tool("wait 1.1 operation_enabled --timeout 50ms");
  EXPECT_EQ(never.code, 4);
  EXPECT_THAT(never.errors, AllOf(HasSubstr("axis 1.1: timed out while waiting for"),
                                  HasSubstr("operation_enabled, shows 0x250 Switch on disabled")));
  EXPECT_EQ(tool("wait 1.1 position > 5 --timeout 50ms").code, 4);
  EXPECT_EQ(tool("expect 1.1 position 5 --within 50ms").code, 1);
  const Finished refused = tool("wait 1.1 no_such_object 5");
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(tool("wait 1.1 target_reachd").errors, HasSubstr("did you mean 'target_reached'?"));
}

TEST_F(WaitAndExpect, ObserveAMotionThatAnotherProgramStarted) {
  ASSERT_EQ(tool("enable 1.1").code, 0);
  ASSERT_EQ(tool("move 1.1 1000 --velocity 1000 --no-wait").code, 0);
  EXPECT_EQ(tool("wait 1.1 position > 500").code, 0);
  const Finished arrived = tool("wait 1.1 target_reached --timeout 5s --json");
  EXPECT_EQ(arrived.code, 0) << arrived.errors;
  EXPECT_THAT(arrived.output, AllOf(HasSubstr("\"command\":\"wait\""), HasSubstr("Operation")));
  const Finished same = tool("expect 1.1 position 1000 --tolerance 1 --within 1s --json");
  EXPECT_EQ(same.code, 0) << same.errors;
  EXPECT_THAT(same.output, HasSubstr("\"comparison\":\"==\",\"expected\":1000"));
  EXPECT_THAT(tool("wait 20ms").output, HasSubstr("bench 1 tick "));
}

}  // namespace
}  // namespace vdrive::test
