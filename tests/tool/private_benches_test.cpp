// SPDX-License-Identifier: Apache-2.0
// `vdrive test` and `vdrive run --private`: a bench for each file, one report, no process left
// over. The benches are either in the processes of the files or services (vdrive_run_over_dds).
#include "support/bench_on_wire.hpp"
#include "support/signals.hpp"
#include "tool/json_lines.hpp"
#include "tool/marked_calls.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/types.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

/// Runs the private benches on the wire under test, local or DDS.
class PrivateBenches : public MarkedCalls {
 protected:
  static Process start_on_wire(const std::string& command, std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--over", runs_over_dds() ? "dds" : "local"});
    return start(command, std::move(arguments));
  }

  static Finished test(std::vector<std::string> arguments) {
    return start_on_wire("test", std::move(arguments)).wait();
  }

  static Finished run_privately(std::vector<std::string> arguments) {
    arguments.emplace_back("--private");
    return start_on_wire("run", std::move(arguments)).wait();
  }
};

TEST_F(PrivateBenches, RunEachFileOnANewBenchAndWriteOneReport) {
  const std::string same = "expect 1.1 position 0\nenable 1.1\nmove 1.1 500\n";
  const Finished finished =
      test({file("a.scn", same), file("b.scn", same + "expect 1.1 position < 100\n"),
            file("c.scn", same), "--jobs", "2", "--junit", report()});
  EXPECT_EQ(finished.code, 1) << finished.output;
  EXPECT_THAT(finished.output, AllOf(HasSubstr("passed  "), HasSubstr("2 of 3 files passed")));
  EXPECT_THAT(finished.errors, HasSubstr("b.scn:4: "));
  const std::string xml = text_of(report());
  EXPECT_THAT(xml, AllOf(HasSubstr("<testsuites tests=\"10\" failures=\"1\""),
                         HasSubstr("a.scn\" tests=\"3\" failures=\"0\""),
                         HasSubstr("b.scn\" tests=\"4\" failures=\"1\""),
                         HasSubstr("line 4: expect 1.1 position &lt; 100"),
                         HasSubstr("b.scn\" line=\"4\"><failure message=\"position: expected"),
                         HasSubstr("type=\"expectation\">"), HasSubstr("\n  axis 1.1 at tick "),
                         HasSubstr("\n  next: ")));
  EXPECT_THAT(finished.errors, AllOf(HasSubstr("\n  axis 1.1 at tick "), HasSubstr("\n  next: ")));
  EXPECT_TRUE(all_have_ended());
}

TEST_F(PrivateBenches, HaveTheAxesOfTheConfigurationAndAreInLockStep) {
  const std::string configuration =
      file("bench.yaml", "clock: {mode: realtime}\naxes:\n  - {number: 3, name: lift}\n");
  const Finished finished = test({file("a.scn", "let axis = nobody\nenable ${axis}\nstep 10\n"),
                                  "--config", configuration, "--set", "axis=lift", "--json"});
  EXPECT_EQ(finished.code, 0) << finished.errors;
  ASSERT_THAT(finished.lines(), SizeIs(2));
  EXPECT_EQ(Json::parse(finished.lines()[0])["passed"], true);
  EXPECT_EQ(Json::parse(finished.lines()[1])["files"], 1);
}

TEST_F(PrivateBenches, OfAFileWithAMistakeAreOneFailedCaseAmongOthers) {
  const std::string good = file("a.scn", "enable 1.1\n");
  const Finished mistake =
      test({file("b.scn", "enabel 1.1\n"), good, "/nonexistent.scn", "--junit", report()});
  EXPECT_EQ(mistake.code, 2);
  EXPECT_THAT(mistake.errors, AllOf(HasSubstr("b.scn:1: 'enabel' is not a command"),
                                    HasSubstr("cannot read '/nonexistent.scn'")));
  EXPECT_THAT(mistake.output, HasSubstr("1 of 3 files passed"));
  EXPECT_THAT(text_of(report()),
              AllOf(HasSubstr("tests=\"3\""), HasSubstr("errors=\"2\""), HasSubstr("b.scn:1: ")));
}

TEST_F(PrivateBenches, AreMadeForEachScenarioOfADirectory) {
  const std::filesystem::path some = std::filesystem::path(file("x", "")).parent_path() / "some";
  std::filesystem::create_directories(some / "deeper");
  std::ofstream(some / "b.scn") << "enable 1.1\n";
  std::ofstream(some / "deeper" / "a.scn") << "expect 1.1 position 0\n";
  std::ofstream(some / "notes.txt") << "no scenario\n";
  const Finished finished = test({some.string(), "--jobs", "1"});
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output,
              AllOf(HasSubstr("2 of 2 files passed"), HasSubstr("deeper/a.scn, 1 line")));
  std::filesystem::create_directory(some / "empty");
  const Finished none = test({(some / "empty").string()});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.errors, HasSubstr("empty' has no scenario, *.scn"));
}

TEST_F(PrivateBenches, DoNotStartAfterAUsageError) {
  const std::string good = file("a.scn", "enable 1.1\n");
  EXPECT_EQ(test({good, "--jobs", "0"}).code, 2);
  EXPECT_EQ(test({"-"}).code, 2);
}

TEST_F(PrivateBenches, AreNotStartedWithABadConfiguration) {
  const std::string good = file("a.scn", "enable 1.1\n");
  const std::string bad = file("bad.yaml", "axis: 5\n");
  const Finished tested = test({good, "--config", bad, "--junit", report()});
  EXPECT_EQ(tested.code, 2);
  EXPECT_THAT(tested.errors, AllOf(HasSubstr("--config: "), HasSubstr("bad.yaml:1: axis: ")));
  EXPECT_THAT(text_of(report()), HasSubstr("errors=\"1\""));
  const Finished run = run_privately({good, "--config", bad});
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(run.errors, tested.errors);
}

TEST_F(PrivateBenches, NameAMissingAxis) {
  const Finished finished = test({file("a.scn", "enable 1.9\n"), "--timeout", "1"});
  EXPECT_EQ(finished.code, 3);
  EXPECT_THAT(finished.errors, HasSubstr("a.scn:1: "));
}

// A service manager sets STATE_DIRECTORY for its services; a bench of a test must not use it.
TEST_F(PrivateBenches, KeepNoParameters) {
  const std::string directory = file("state", "");
  std::filesystem::remove(directory);
  std::filesystem::create_directory(directory);
  setenv("STATE_DIRECTORY", directory.c_str(), 1);  // NOLINT(concurrency-mt-unsafe): one thread
  const Finished finished = test({file("a.scn", "refused 0x08000020 store 1.1\n")});
  unsetenv("STATE_DIRECTORY");  // NOLINT(concurrency-mt-unsafe): one thread
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_TRUE(std::filesystem::is_empty(directory));
}

TEST_F(PrivateBenches, OfRunAreNewForEachFile) {
  const std::string same = "expect 1.1 position 0\nenable 1.1\nmove 1.1 500\n";
  const Finished finished =
      run_privately({file("a.scn", same), file("b.scn", same), "--junit", report()});
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output, HasSubstr("2 of 2 files passed"));
  EXPECT_THAT(text_of(report()), HasSubstr("<testsuites tests=\"6\" failures=\"0\""));
}

// By the time the user reads the message, the bench and its events are gone.
TEST_F(PrivateBenches, GiveNoAdviceThatNeedsThemAfterTheirEnd) {
  const std::string faulted =
      file("fault.scn", "disturb 1.1 over_temperature\nwait 1.1 fault\nmove 1.1 5\n");
  const std::string limited =
      file("limit.scn", "enable 1.1\ndisturb 1.1 positive_limit\nmove 1.1 1000\n");
  for (const Finished& finished : {run_privately({faulted, limited}), test({faulted, limited})}) {
    EXPECT_EQ(finished.code, 1);
    EXPECT_THAT(finished.errors,
                AllOf(HasSubstr("next: the line of the axis shows the cause of the fault; "
                                "'reset 1.1' above this line ends it"),
                      HasSubstr("next: 'vdrive run --private --live' shows the axes"),
                      Not(HasSubstr("vdrive events"))));
  }
}

TEST_F(PrivateBenches, OfRunContinueAfterAFileThatFailed) {
  const Finished finished = run_privately(
      {file("a.scn", "expect 1.1 position 1\n"), file("b.scn", "expect 1.1 position 0\n")});
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, AllOf(HasSubstr("a.scn:1: "), HasSubstr("1 of 2 files passed")));
}

TEST_F(PrivateBenches, OfRunHaveTheAxesOfAllFilesBeforeTheFirstCommand) {
  const Finished finished =
      run_privately({file("a.scn", "enable 1.1\n"), file("b.scn", "enable 1.9\n"), "--json"});
  EXPECT_EQ(finished.code, 3);
  EXPECT_THAT(finished.errors, HasSubstr("b.scn:1: "));
  EXPECT_THAT(finished.output, Not(HasSubstr("enable 1.1")));
}

// So long in drive time that it runs until it is ended.
constexpr const char* kLong =
    "enable 1.1\nmove 1.1 1000000 --velocity 1 --timeout 3600000\nfinally\ndisable 1.1\n";

TEST_F(PrivateBenches, ThatCrashFailTheirFileAlone) {
  Process call = start_on_wire("test", {file("long.scn", kLong), file("good.scn", "enable 1.1\n"),
                                        "--jobs", "1", "--junit", report()});
  const auto run = wait_for_process({"--private", "long.scn"});
  ASSERT_TRUE(run);
  send_signal(*run, SIGSEGV);
  const Finished finished = call.wait();
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.output, AllOf(HasSubstr("failed  "), HasSubstr("1 of 2 files passed")));
  EXPECT_THAT(finished.errors, HasSubstr("ended by signal 11"));  // SIGSEGV
  EXPECT_THAT(text_of(report()), HasSubstr("good.scn\" tests=\"1\" failures=\"0\""));
  EXPECT_TRUE(all_have_ended());
}

TEST_F(PrivateBenches, OfRunThatCrashFailTheirFileAlone) {
  for (const int signal : {SIGABRT, SIGKILL}) {  // a sanitizer catches SIGSEGV
    Process call = start_on_wire(
        "run", {"--private", file("first.scn", "enable 1.1\n"), file("long.scn", kLong),
                file("last.scn", "expect 1.1 position 0\n"), "--junit", report()});
    ASSERT_THAT(call.read_line(), HasSubstr("enable 1.1"));
    ASSERT_THAT(call.read_line(), HasSubstr("passed  "));
    ASSERT_THAT(call.read_line(), HasSubstr("enable 1.1"));
    ASSERT_THAT(call.read_line(), HasSubstr("move 1.1"));
    const auto run = process_with({"__file", "long.scn"});
    ASSERT_TRUE(run);
    send_signal(*run, signal);
    const Finished finished = call.wait();
    EXPECT_EQ(finished.code, 1);
    EXPECT_THAT(finished.output,
                AllOf(HasSubstr("failed  "), HasSubstr("long.scn, 1 of 3 lines done"),
                      HasSubstr("expect 1.1 position 0"), HasSubstr("last.scn, 1 line")));
    EXPECT_THAT(finished.errors,
                AllOf(HasSubstr("long.scn: ended by signal " + std::to_string(signal)),
                      HasSubstr("2 of 3 files passed")));
    EXPECT_THAT(text_of(report()),
                AllOf(HasSubstr("first.scn\" tests=\"1\" failures=\"0\" skipped=\"0\""),
                      HasSubstr("long.scn\" tests=\"4\" failures=\"0\" skipped=\"2\" errors=\"1\""),
                      HasSubstr("last.scn\" tests=\"1\" failures=\"0\" skipped=\"0\"")));
    EXPECT_TRUE(all_have_ended());
  }
}

// As with `run` without --private: a file may change later, and a pipe can be read only once.
TEST_F(PrivateBenches, OfRunCarryOutWhatWasReadAtTheStart) {
  const std::string last = file("last.scn", "expect 1.1 position 0\n");
  Process call(VDRIVE_TOOL,
               {"run", "--private", "--over", runs_over_dds() ? "dds" : "local", "-", last},
               "let axis = 1.1\nenable ${axis}  # from a pipe\n");
  ASSERT_THAT(call.read_line(), HasSubstr("   2  enable 1.1"));
  std::filesystem::remove(last);
  const Finished finished = call.wait();
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(finished.output,
              AllOf(HasSubstr("passed  <stdin>, 1 line"), HasSubstr("last.scn, 1 line"),
                    HasSubstr("2 of 2 files passed")));
}

TEST_F(PrivateBenches, OfRunEndWithTheReaderOfItsOutput) {
  const std::string line = "expect 1.1" + std::string(350, ' ') + "position 0\n";
  std::string more_than_a_pipe_holds;
  for (int i = 0; i < 250; ++i) more_than_a_pipe_holds += line;
  Process call = start_on_wire("run", {"--private", file("a.scn", more_than_a_pipe_holds),
                                       file("b.scn", "enable 1.1\n"), "--junit", report()});
  ASSERT_THAT(call.read_line(), HasSubstr("expect 1.1"));
  call.stop_reading();
  const Finished finished = call.wait();
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_THAT(text_of(report()), AllOf(HasSubstr("a.scn"), Not(HasSubstr("b.scn"))));
}

/// Ends a call by a signal while its scenario runs.
class TestRunEndedBy : public PrivateBenches, public testing::WithParamInterface<int> {};

TEST_P(TestRunEndedBy, ASignalLeavesNoProcessBehind) {
  const int signal = GetParam();
  Process call =
      start_on_wire("test", {file("a.scn", kLong), file("b.scn", kLong), "--junit", report()});
  ASSERT_TRUE(wait_for_process({"a.scn", "--private"}));
  call.send(signal);
  const Finished finished = call.wait();
  EXPECT_EQ(finished.code, signal == SIGKILL ? -SIGKILL : 130);
  EXPECT_TRUE(all_have_ended());
  if (signal != SIGKILL) {
    EXPECT_THAT(text_of(report()), HasSubstr("<testsuites"));
  }
}

class PrivateRunEndedBy : public TestRunEndedBy {};

TEST_P(PrivateRunEndedBy, ASignalRunsTheFinalLines) {
  const int signal = GetParam();
  Process call = start_on_wire("run", {file("a.scn", kLong), "--private"});
  ASSERT_THAT(call.read_line(), HasSubstr("enable"));
  ASSERT_THAT(call.read_line(), HasSubstr("move"));
  call.send(signal);
  const Finished finished = call.wait();
  EXPECT_EQ(finished.code, 130);
  EXPECT_THAT(finished.output, HasSubstr("disable 1.1"));
  EXPECT_TRUE(all_have_ended());
}

TEST_P(PrivateRunEndedBy, ASignalRunsTheFinalLinesOfOneFileAndNoFurtherFile) {
  Process call = start_on_wire("run", {file("a.scn", kLong), file("b.scn", "enable 1.2\n"),
                                       "--private", "--junit", report()});
  ASSERT_THAT(call.read_line(), HasSubstr("enable"));
  ASSERT_THAT(call.read_line(), HasSubstr("move"));
  call.send(GetParam());
  const Finished finished = call.wait();
  EXPECT_EQ(finished.code, 130);
  EXPECT_THAT(finished.output, AllOf(HasSubstr("disable 1.1"), Not(HasSubstr("enable 1.2"))));
  EXPECT_THAT(text_of(report()),
              AllOf(HasSubstr("<testsuites tests=\"3\" failures=\"1\""), Not(HasSubstr("b.scn"))));
  EXPECT_TRUE(all_have_ended());
}

std::string name_of_signal(const testing::TestParamInfo<int>& signal) {
  return sigabbrev_np(signal.param);
}

INSTANTIATE_TEST_SUITE_P(Signals, TestRunEndedBy, testing::Values(SIGINT, SIGTERM, SIGHUP, SIGKILL),
                         name_of_signal);
INSTANTIATE_TEST_SUITE_P(Signals, PrivateRunEndedBy, testing::Values(SIGINT, SIGTERM, SIGHUP),
                         name_of_signal);

}  // namespace
}  // namespace vdrive::test
