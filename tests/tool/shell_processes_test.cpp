// SPDX-License-Identifier: Apache-2.0
// `vdrive shell` on a terminal, and without standard input.
#include "support/temporary_directory.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "tool/pseudo_terminal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>

namespace vdrive::test {
namespace {

using testing::HasSubstr;

class Shell : public testing::Test {
 protected:
  RunningService service_{"--clock lockstep"};
};

TEST_F(Shell, EndsAtOnceWhenItsStandardInputIsClosed) {
  const std::string command =
      std::string(VDRIVE_TOOL) + " --domain " + std::to_string(test_domain()) + " shell <&-";
  const Finished finished = Process("/bin/sh", {"-c", "exec timeout 60 " + command}).wait();
  EXPECT_EQ(finished.code, 0) << finished.errors;
}

class ShellEndedBy : public testing::TestWithParam<int> {};

// The pipe stays open, so only the signal ends the shell; the failed line no longer counts.
TEST_P(ShellEndedBy, ASignalHasTheExitCodeOfAnInterrupt) {
  const RunningService service("--clock lockstep");
  const TemporaryDirectory directory;
  const std::string lines = directory.path() / "lines";
  ASSERT_EQ(mkfifo(lines.c_str(), S_IRUSR | S_IWUSR), 0);
  const std::string command =
      std::string(VDRIVE_TOOL) + " --domain " + std::to_string(test_domain()) + " shell";
  Process shell("/bin/sh", {"-c", "exec 3<>" + lines +
                                      "; echo 'nothing' >&3; echo 'read 1.1 position' >&3; exec " +
                                      command + " <&3"});
  EXPECT_THAT(shell.read_line(), HasSubstr("1.1 position"));
  shell.send(GetParam());
  const Finished finished = shell.wait();
  EXPECT_EQ(finished.code, 130) << finished.errors;
}

INSTANTIATE_TEST_SUITE_P(Signals, ShellEndedBy, testing::Values(SIGINT, SIGTERM, SIGHUP),
                         [](const testing::TestParamInfo<int>& signal) -> std::string {
                           return sigabbrev_np(signal.param);
                         });

// The command waits for an axis that is never enabled. A signal that arrives before the command
// begins has the same effect.
TEST(PipedShell, IsEndedByASignalToTheCommandThatRuns) {
  const RunningService service("--clock realtime");
  const TemporaryDirectory directory;
  const std::string lines = directory.path() / "lines";
  std::ofstream(lines)
      << "read 1.1 position\nwait 1.1 operation_enabled --timeout 60\nread 1.1 velocity\n";
  const std::string command =
      std::string(VDRIVE_TOOL) + " --domain " + std::to_string(test_domain()) + " shell";
  Process shell("/bin/sh", {"-c", "exec " + command + " <" + lines});
  EXPECT_THAT(shell.read_line(), HasSubstr("1.1 position"));
  shell.send(SIGINT);
  const Finished finished = shell.wait();
  EXPECT_EQ(finished.code, 130) << finished.errors;
  EXPECT_EQ(finished.output, "") << "the next line was not carried out";
}

class ShellOnATerminal : public Shell {
 protected:
  ShellOnATerminal()
      : terminal_(24, 80, "shell", {"XDG_STATE_HOME=" + directory_.path().string()}) {}

  bool shows(const std::string& text) {
    return terminal_.wait_until([&](const Screen& /*screen*/) {
      return terminal_.output().find(text) != std::string::npos;
    });
  }

  /// Waits for the prompt after `text`, because keys typed earlier would go to the running command.
  bool shows_and_awaits_a_line(const std::string& text) {
    return terminal_.wait_until([&](const Screen& /*screen*/) {
      const std::size_t place = terminal_.output().rfind(text);
      const std::size_t prompt = terminal_.output().rfind("vdrive> ");
      return place != std::string::npos && prompt != std::string::npos && prompt > place;
    });
  }

  TemporaryDirectory directory_;
  PseudoTerminal terminal_;
};

TEST_F(ShellOnATerminal, CompletesWordsKeepsAHistoryAndDropsALineOnCtrlC) {
  ASSERT_TRUE(shows("vdrive> "));
  terminal_.type("ena\t1.1\n");
  ASSERT_TRUE(shows_and_awaits_a_line("Operation enabled")) << terminal_.output();
  terminal_.type("move 1.1 999999");
  ASSERT_TRUE(shows("999999"));
  terminal_.type("\x03");
  ASSERT_TRUE(shows_and_awaits_a_line("^C")) << terminal_.output();
  terminal_.type("read 1.1 profile_vel\t\n");
  ASSERT_TRUE(shows_and_awaits_a_line("profile_velocity = ")) << terminal_.output();
  terminal_.type("\x04");
  EXPECT_EQ(terminal_.wait(), 0);
  std::ifstream file(directory_.path() / "vdrive" / "history");
  std::stringstream history;
  history << file.rdbuf();
  EXPECT_THAT(history.str(), HasSubstr("enable"));
  EXPECT_THAT(tool("status 1.1").output, HasSubstr("demand 0")) << "the move was dropped";
}

TEST_F(ShellOnATerminal, ContinuesAfterAnInterruptedCommand) {
  ASSERT_TRUE(shows("vdrive> "));
  terminal_.type("enable 1.1\n");
  ASSERT_TRUE(shows_and_awaits_a_line("Operation enabled")) << terminal_.output();
  terminal_.type("move 1.1 1000000 --velocity 1 --timeout 3600000\n");
  // The line has been read, and the axis moves.
  while (tool("status 1.1 --json").output.find("set-point acknowledge") == std::string::npos) {
  }
  terminal_.interrupt();
  ASSERT_TRUE(shows_and_awaits_a_line("interrupted")) << terminal_.output();
  terminal_.type("read 1.1 target_position\n");
  ASSERT_TRUE(shows_and_awaits_a_line("position_user_target_value = 1000000"))
      << terminal_.output();
  terminal_.type("exit\n");
  EXPECT_EQ(terminal_.wait(), 0);
}

// In lock-step, the jog itself steps the bench. 13 is the character code of Enter.
TEST(JogOnATerminal, StopsTheAxisOnEnter) {
  const RunningService service("--clock lockstep");
  ASSERT_EQ(tool("enable 1.1").code, 0);
  PseudoTerminal jog(24, 80, "jog 1.1 10000");
  const auto shows = [](const std::string& text) {
    return tool("status 1.1 --json").output.find(text) != std::string::npos;
  };
  ASSERT_TRUE(jog.wait_until([&](const Screen& /*screen*/) {
    return jog.output().find("Enter or Ctrl-C stops the axis") != std::string::npos;
  })) << jog.output();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!shows("\"velocity_demand_value\":10000,")) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
  }
  jog.type("\r");
  EXPECT_EQ(jog.wait(), 0) << jog.output();
  EXPECT_TRUE(shows("\"velocity_demand_value\":0,"));
}

}  // namespace
}  // namespace vdrive::test
