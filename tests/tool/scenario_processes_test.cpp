// SPDX-License-Identifier: Apache-2.0
// Scenarios as processes: events that end their waits, and the effects of an interrupt.
#include "support/test_domain.hpp"
#include "tool/json_lines.hpp"
#include "tool/process.hpp"
#include "vdrive/client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <string>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kPatient =
    "--clock realtime --axes 2 --config " VDRIVE_SOURCE_DIR "/tests/data/patient.yaml";

/// A scenario on standard input whose last line waits for a condition that never holds.
class WaitingScenario {
 public:
  /// @param lines with one line of output each; the last one waits
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

// Without messages from the stopped program, the bench releases its axis.
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

Json status_of(const std::string& axis) {
  return Json::parse(tool("status " + axis + " --json").output);
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

}  // namespace
}  // namespace vdrive::test
