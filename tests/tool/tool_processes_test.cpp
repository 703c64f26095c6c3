// SPDX-License-Identifier: Apache-2.0
// The program vdrive as a process: signals, pipes, full disks, two programs, no service.
#include "support/test_domain.hpp"
#include "tool/json_lines.hpp"
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;
using testing::Not;
using testing::SizeIs;

TEST(Tool, WithoutAServiceExitsThreeWithinTheTimeoutWithAnError) {
  for (const char* const words :
       {"list", "status 1.1", "read x 0x6041", "enable 1.1", "step 1", "watch 1.1"}) {
    const Finished finished = tool(std::string(words) + " --timeout 0.2");
    EXPECT_EQ(finished.code, 3) << words;
    EXPECT_THAT(finished.output, IsEmpty()) << words;
    EXPECT_THAT(finished.errors, HasSubstr("no ")) << words;
    EXPECT_LT(finished.duration, 5s) << words;
  }
}

TEST(Tool, TakesTheDomainFromTheEnvironment) {
  const RunningService service("--clock lockstep");
  setenv("VDRIVE_DOMAIN", std::to_string(test_domain()).c_str(), 1);  // NOLINT(*-mt-unsafe)
  EXPECT_EQ(Process(VDRIVE_TOOL, {"list"}).wait().code, 0);
}

class ToolInLockStep : public testing::Test {
 protected:
  RunningService service_{"--clock lockstep"};
};

TEST_F(ToolInLockStep, WatchEndsOnAnInterruptWith130) {
  Process watch(VDRIVE_TOOL, tool_arguments("watch 1.1"));
  EXPECT_THAT(watch.read_line(), HasSubstr("Switch on disabled"));
  watch.send(SIGINT);
  const Finished finished = watch.wait();
  EXPECT_EQ(finished.code, 130);
  EXPECT_THAT(finished.errors, IsEmpty());
}

TEST(Recording, IsCompleteAfterAnInterruptAndExitsWith130) {
  const RunningService service("--axes 2");
  Process recorder(VDRIVE_TOOL, tool_arguments("record - 1.1"));
  EXPECT_THAT(recorder.read_line(), HasSubstr("axis,name,tick"));
  EXPECT_THAT(recorder.read_line(), HasSubstr("1.1,"));
  recorder.send(SIGINT);
  const Finished finished = recorder.wait();
  EXPECT_EQ(finished.code, 130);
  EXPECT_THAT(finished.errors, HasSubstr("recorded "));
}

TEST_F(ToolInLockStep, AnInterruptedRunExitsWith130AndReleasesItsAxes) {
  ASSERT_EQ(tool("enable 1.1").code, 0);
  Process move(VDRIVE_TOOL, tool_arguments("run - --json"),
               "step 1\nmove 1.1 1000000 --velocity 1 --timeout 3600000\n");
  EXPECT_THAT(move.read_line(), HasSubstr("step 1"));
  move.send(SIGINT);
  EXPECT_EQ(move.wait().code, 130);
  EXPECT_TRUE(json_of(tool("status 1.1 --json")).at(0)["owner"].is_null());
}

TEST_F(ToolInLockStep, AClosedOutputPipeIsNotAnError) {
  Process watch(VDRIVE_TOOL, tool_arguments("watch 1.1 --json --count 3"));
  watch.stop_reading();
  EXPECT_EQ(tool("step 5000").code, 0);  // so that watch has something to print
  const Finished finished = watch.wait();
  EXPECT_EQ(finished.code, 0);
  EXPECT_THAT(finished.errors, IsEmpty());
}

/// Runs the tool with /dev/full as standard output, where writes fail as on a full disk.
Finished tool_on_full_disk(const std::string& words) {
  return Process("/bin/sh", {"-c", VDRIVE_TOOL " --domain " + std::to_string(test_domain()) + " " +
                                       words + " > /dev/full"})
      .wait();
}

TEST_F(ToolInLockStep, EveryCommandFailsWhoseOutputCouldNotBeWritten) {
  for (const char* const words :
       {"list", "--json list", "status 1.1", "read 1.1 0x6041", "step 1", "watch 1.1 --count 1",
        "record - 1.1 --count 1", "dictionary", "completion bash", "--help", "--version"}) {
    const Finished finished = tool_on_full_disk(words);
    EXPECT_EQ(finished.code, 1) << words;
    EXPECT_THAT(finished.errors,
                HasSubstr("vdrive: standard output could not be written: No space left"))
        << words;
  }
}

TEST_F(ToolInLockStep, ARefusalKeepsItsExitCodeWhereTheOutputCouldNotBeWritten) {
  EXPECT_EQ(tool_on_full_disk("--json write 1.1 0x6041 1").code, 5);
}

TEST(ToolInRealtime, CommandsWithinHalfASecond) {
  const RunningService service("--clock realtime");
  ASSERT_EQ(tool("enable 1.1").code, 0);
  const Finished moved = tool("move 1.1 1000 --json");
  EXPECT_EQ(moved.code, 0) << moved.errors;
  EXPECT_EQ(tool("step 1").code, 5);
  // The median, since other tests may keep the machine busy.
  std::vector<std::chrono::milliseconds> durations;
  for (int i = 0; i < 7; ++i) durations.push_back(tool("read 1.1 0x6041").duration);
  std::ranges::sort(durations);
  EXPECT_LT(durations[3], 500ms);
}

TEST(ToolInRealtime, WatchStreamsWhileAnotherCallMoves) {
  const RunningService service("--clock realtime");
  ASSERT_EQ(tool("enable 1.1").code, 0);
  Process watch(VDRIVE_TOOL, tool_arguments("watch 1.1 --json --count 15"));
  ASSERT_EQ(tool("move 1.1 5000 --velocity 5000").code, 0);
  const Finished finished = watch.wait();
  EXPECT_EQ(finished.code, 0);
  const auto samples = json_of(finished);
  ASSERT_THAT(samples, SizeIs(15));
  EXPECT_NE(samples.front()["load_position_actual_value"],
            samples.back()["load_position_actual_value"]);
}

/// A service in real time, and another terminal where axis 1.1 moves to a distant target.
class MoveOfAnotherProgram : public testing::Test {
 protected:
  /// @param words options of the move
  void begin(const std::string& words = "") {
    ASSERT_EQ(tool("enable 1.1").code, 0);
    move_.emplace(VDRIVE_TOOL, tool_arguments("move 1.1 10000000 --velocity 1000 " + words));
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    while (speed() == 0) ASSERT_LT(std::chrono::steady_clock::now(), deadline);
  }

  static std::int64_t speed() { return status()["velocity_demand_value"].get<std::int64_t>(); }

  static Json status() { return json_of(tool("status 1.1 --json")).at(0); }

  // With a long watchdog time, for busy machines.
  RunningService service_{"--clock realtime --axes 2 --config " VDRIVE_SOURCE_DIR
                          "/tests/data/patient.yaml"};
  std::optional<Process> move_;
};

TEST_F(MoveOfAnotherProgram, IsHaltedFromThisTerminal) {
  begin();
  const Finished halted = tool("halt 1.1 --wait");
  EXPECT_EQ(halted.code, 0) << halted.errors;
  const Finished moved = move_->wait();
  EXPECT_EQ(moved.code, 1);
  EXPECT_THAT(moved.errors, HasSubstr("axis 1.1 was halted before it reached its target"));
  EXPECT_EQ(speed(), 0);
}

TEST_F(MoveOfAnotherProgram, IsQuickStoppedFromThisTerminal) {
  begin();
  EXPECT_EQ(tool("quick-stop 1.1").code, 0);
  EXPECT_EQ(move_->wait().code, 1);
  EXPECT_EQ(status()["state"], "Switch on disabled");
}

TEST_F(MoveOfAnotherProgram, IsStoppedByAWriteOfTheControlword) {
  begin();
  EXPECT_EQ(tool("write 1.1 0x6040 0x06").code, 5) << "no stop";
  EXPECT_EQ(tool("write 1.1 0x6040 0x02").code, 0);
  EXPECT_EQ(move_->wait().code, 1);
}

TEST_F(MoveOfAnotherProgram, IsStoppedWithItsBench) {
  begin();
  const Finished stopped = tool("stop --json");
  EXPECT_EQ(stopped.code, 0) << stopped.errors;
  const Json stopped_json = json_of(stopped).at(0);
  EXPECT_THAT(keys(stopped_json), ElementsAre("bench", "command", "axes", "outcome"));
  EXPECT_EQ(stopped_json["axes"], 2);
  EXPECT_EQ(move_->wait().code, 1);
  EXPECT_EQ(status()["state"], "Switch on disabled");
  EXPECT_EQ(tool("stop 1").output, "bench 1: quick stop of 2 axes\n");
  EXPECT_EQ(tool("stop 7 --timeout 0.3").code, 3);
}

TEST_F(MoveOfAnotherProgram, IsTakenOver) {
  begin();
  const Finished refused = tool("disable 1.1");
  EXPECT_EQ(refused.code, 5);
  // Another program on this machine, started by the tool itself.
  EXPECT_THAT(refused.errors,
              MatchesRegex("vdrive: control of axis 1\\.1 refused: axis 1\\.1 is controlled by "
                           "vdrive \\(process [0-9]+ on .+\\), session 0x[0-9a-f]+; --take-over "
                           "takes it, or end that program\n"));
  const Json seen = status();
  EXPECT_EQ(seen["owner_name"]["program"], "vdrive");
  EXPECT_EQ(seen["owner_name"]["process"], move_->id());
  EXPECT_EQ(tool("disable 1.1 --take-over").code, 0);
  const Finished moved = move_->wait();
  EXPECT_EQ(moved.code, 5);
  EXPECT_THAT(
      moved.errors,
      MatchesRegex(
          "vdrive: another session has taken the axis: this call ends and does not stop it: axis "
          "1\\.1 is controlled by vdrive \\(process [0-9]+ on .+\\), session 0x[0-9a-f]+.*\n"));
}

// The move of the other program never ends here, so only the loss of control can end this one.
TEST_F(MoveOfAnotherProgram, IsTakenOverByAMove) {
  begin();
  ASSERT_EQ(tool("move 1.1 -10000000 --velocity 1000 --take-over --no-wait").code, 0);
  const Finished moved = move_->wait();
  EXPECT_EQ(moved.code, 5);
  EXPECT_THAT(moved.errors, HasSubstr("another session has taken the axis"));
  EXPECT_NE(speed(), 0) << "it goes on for the other one";
}

// timeout(1) signals its program and then the process group; on a closed terminal, both the shell
// and the kernel send a signal.
TEST_F(MoveOfAnotherProgram, TreatsSimultaneousSignalsAsOne) {
  begin("--stop-on-interrupt");
  move_->send(SIGTERM);
  move_->send(SIGHUP);
  move_->send(SIGTERM);
  const Finished moved = move_->wait();
  EXPECT_EQ(moved.code, 130);
  EXPECT_EQ(moved.errors, "vdrive: interrupted; axis 1.1 is halted\n");
}

TEST_F(MoveOfAnotherProgram, ReportsOnAnInterruptThatTheAxisStillMoves) {
  begin();
  move_->send(SIGINT);
  const Finished moved = move_->wait();
  EXPECT_EQ(moved.code, 130);
  EXPECT_EQ(moved.errors,
            "vdrive: interrupted; axis 1.1 was not stopped: it continues to its target while its "
            "bench runs\n");
  EXPECT_NE(speed(), 0);
}

TEST_F(MoveOfAnotherProgram, HaltsTheAxisOnAnInterruptWithItsOption) {
  begin("--stop-on-interrupt");
  move_->send(SIGINT);
  const Finished moved = move_->wait();
  EXPECT_EQ(moved.code, 130);
  EXPECT_EQ(moved.errors, "vdrive: interrupted; axis 1.1 is halted\n");
  EXPECT_EQ(speed(), 0);
}

/// A command that waits, and the condition that shows its axis in motion.
struct WaitingCommand {
  const char* axis;
  const char* words;
  const char* under_way;  ///< a condition of `wait`
};

// Commands without a motion come first: they have begun by the time the others move.
constexpr std::array kWaitingCommands{
    WaitingCommand{"1.1", "wait 1.1 position == 20000000", "velocity_demand_value == 0"},
    WaitingCommand{"1.1", "expect 1.1 position 20000000 --within 1h", "velocity_demand_value == 0"},
    WaitingCommand{"1.1", "wait 1.1 fault", "velocity_demand_value == 0"},
    WaitingCommand{"1.1", "move 1.1 10000000 --velocity 1000", "velocity_demand_value != 0"},
    WaitingCommand{"1.2", "home 1.2 --method 17 --speed 100 --creep 100",
                   "velocity_demand_value != 0"},
    WaitingCommand{"1.3", "velocity 1.3 100000 --acceleration 1000", "velocity_demand_value != 0"},
    WaitingCommand{"1.4", "torque 1.4 100 --slope 1", "torque_demand != 0"},
    WaitingCommand{"1.5", "jog 1.5 1000 --for 1h", "velocity_demand_value == 1000"},
    // 6084h = 1 UU/s²: the halt takes 1000 s.
    WaitingCommand{"1.6", "halt 1.6 --wait", "velocity_demand_value < 1000"},
};

/// Six axes in real time, and a waiting program for each command.
class CommandsThatWait : public testing::Test {
 protected:
  void SetUp() override {
    const Finished prepared =
        tool("run -", "enable 1.*\nwrite 1.6 profile_dec 1\nvelocity 1.6 1000\n");
    ASSERT_EQ(prepared.code, 0) << prepared.errors;
    for (const WaitingCommand& command : kWaitingCommands) {
      programs_.push_back(std::make_unique<Process>(
          VDRIVE_TOOL, tool_arguments(std::string(command.words) + " --timeout 1h")));
      const Finished seen = tool("wait " + std::string(command.axis) + " " + command.under_way);
      ASSERT_EQ(seen.code, 0) << command.words << ": " << seen.errors;
    }
  }

  /// @return the outcome of each program, once the service has ended.
  std::vector<Finished> ends() {
    std::vector<Finished> ends;
    for (const auto& program : programs_) ends.push_back(program->wait());
    return ends;
  }

  RunningService service_{"--axes 6 --config " VDRIVE_SOURCE_DIR "/tests/data/patient.yaml"};
  std::vector<std::unique_ptr<Process>> programs_;
};

// They end about 1.6 s after the kill; a search for the lost bench would last until --timeout.
TEST_F(CommandsThatWait, AreToldOfAKilledServiceByItsSilence) {
  const auto killed = std::chrono::steady_clock::now();
  service_.kill();
  const std::vector<Finished> ended = ends();
  EXPECT_LT(std::chrono::steady_clock::now() - killed, 20s);
  for (std::size_t i = 0; i < ended.size(); ++i) {
    EXPECT_EQ(ended[i].code, 1) << kWaitingCommands.at(i).words;
    EXPECT_THAT(ended[i].errors,
                MatchesRegex("vdrive: bench 1 stopped sending or ended: its newest "
                             "sample is 1[5-9][0-9][0-9] ms old, the limit is "
                             "1500 ms\n"))
        << kWaitingCommands.at(i).words;
  }
}

TEST_F(CommandsThatWait, AreToldThatTheirServiceShutsDown) {
  EXPECT_EQ(service_.stop().code, 0);
  const std::vector<Finished> ended = ends();
  for (std::size_t i = 0; i < ended.size(); ++i) {
    // The halt may have completed at standstill before the service removed the power.
    if (ended[i].code == 0 && std::string(kWaitingCommands.at(i).axis) == "1.6") continue;
    EXPECT_EQ(ended[i].code, 1) << kWaitingCommands.at(i).words;
    EXPECT_THAT(ended[i].errors,
                MatchesRegex("vdrive: bench 1 (is shutting down: its service brakes the axes, then "
                             "exits|went offline: its service has ended).*\n"))
        << kWaitingCommands.at(i).words;
  }
}

std::string value_of(const std::string& axis, const std::string& object) {
  return nlohmann::json::parse(tool("read " + axis + " " + object + " --json").output)["value"]
      .dump();
}

class JogEndedBy : public testing::TestWithParam<int> {};

TEST_P(JogEndedBy, ASignalStopsAndReleasesTheAxis) {
  const RunningService service("");
  ASSERT_EQ(tool("enable 1.1").code, 0);
  Process jog(VDRIVE_TOOL, tool_arguments("jog 1.1 10000 --for 60s"));
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (value_of("1.1", "0x606B") != "10000") {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
  }
  jog.send(GetParam());
  EXPECT_EQ(jog.wait().code, 130);
  EXPECT_EQ(value_of("1.1", "0x60FF"), "0");
  EXPECT_EQ(value_of("1.1", "0x606B"), "0");
  EXPECT_EQ(value_of("1.1", "0x603F"), "0") << "its watchdog would be a fault";
}

// A program receives SIGHUP when its terminal is closed.
INSTANTIATE_TEST_SUITE_P(Signals, JogEndedBy, testing::Values(SIGINT, SIGTERM, SIGHUP),
                         [](const testing::TestParamInfo<int>& signal) -> std::string {
                           return sigabbrev_np(signal.param);
                         });

// At 1000 UU/s² the velocity is reached after 100 s.
TEST(VelocityEndedByASignal, HaltsAndReleasesTheAxis) {
  const RunningService service("");
  ASSERT_EQ(tool("enable 1.1").code, 0);
  Process velocity(VDRIVE_TOOL, tool_arguments("velocity 1.1 100000 --acceleration 1000"));
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (value_of("1.1", "0x606B") == "0") {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
  }
  velocity.send(SIGINT);
  const Finished finished = velocity.wait();
  EXPECT_EQ(finished.code, 130);
  EXPECT_EQ(finished.errors, "vdrive: interrupted; axis 1.1 is halted\n");
  EXPECT_EQ(value_of("1.1", "0x606B"), "0");
  const Json seen = json_of(tool("status 1.1 --json")).at(0);
  EXPECT_TRUE(seen["owner"].is_null());
  EXPECT_EQ(seen["error_code"], 0) << "its watchdog would be a fault";
}

TEST(Nohup, KeepsAProgramWhoseTerminalIsClosed) {
  const RunningService service("--clock lockstep");
  Process watch("/usr/bin/nohup", {VDRIVE_TOOL, "--domain", std::to_string(test_domain()), "--json",
                                   "events", "--follow"});
  ASSERT_EQ(tool("enable 1.1").code, 0);
  ASSERT_NE(watch.read_line(), "");
  watch.send(SIGHUP);
  ASSERT_EQ(tool("disable 1.1").code, 0);
  EXPECT_NE(watch.read_line(), "");
  watch.send(SIGINT);
  EXPECT_EQ(watch.wait().code, 130);
}

class Events : public testing::Test {
 protected:
  Events() { EXPECT_EQ(tool("run -", "enable 1.1\ndisturb 1.1 over_current\nwait 5ms\n").code, 0); }

  RunningService service_{"--clock lockstep"};
};

TEST_F(Events, AreFollowedAsTheyArrive) {
  Process events(VDRIVE_TOOL, tool_arguments("events x --follow"));
  std::string line;
  do {
    line = events.read_line();
  } while (!line.empty() && line.find("fault 0x") == std::string::npos);
  EXPECT_EQ(tool("run -", "disturb 1.1 none\nreset 1.1\n").code, 0);
  do {
    line = events.read_line();
  } while (!line.empty() && line.find(" reset") == std::string::npos);
  EXPECT_THAT(line, HasSubstr("fault 0x"));
  events.send(SIGINT);
  EXPECT_EQ(events.wait().code, 130);
}

// HealthyBench.RefusesNothingOfAnyCommandOfTheTool covers the other commands.
TEST_F(Events, HaveNoRefusalOfTheDoctor) {
  EXPECT_THAT(tool("doctor").output, HasSubstr("bench 1"));
  const std::vector<std::string> events = tool("events --json").lines();
  EXPECT_THAT(events, Not(IsEmpty()));
  EXPECT_THAT(events, Each(Not(HasSubstr("refused"))));
}

}  // namespace
}  // namespace vdrive::test
