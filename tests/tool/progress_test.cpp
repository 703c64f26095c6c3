// SPDX-License-Identifier: Apache-2.0
// The progress line of commands that last longer than a second, on a terminal and elsewhere.
#include "support/temporary_directory.hpp"
#include "tool/process.hpp"
#include "tool/pseudo_terminal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr std::size_t kRowsOfProgress = 10;
constexpr const char* kErasedRow = "\r\x1b[K";  // removes the progress line

/// @return a condition for PseudoTerminal::wait_until.
auto has_row(const std::string& begin, const std::string& end = "") {
  return [begin, end](const Screen& screen) {
    const std::vector<std::string> rows = screen.rows();
    return std::ranges::any_of(rows, [&](const std::string& row) {
      return row.starts_with(begin) && row.ends_with(end);
    });
  };
}

std::string rows_on(const PseudoTerminal& terminal) {
  return "screen:\n" + testing::PrintToString(terminal.screen().rows()) + "\nwritten:\n" +
         testing::PrintToString(terminal.output());
}

/// Two axes in real time; the first one is enabled.
class ProgressOnATerminal : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(tool("enable 1.1").code, 0); }

  static void expect_no_progress(const PseudoTerminal& terminal) {
    EXPECT_THAT(terminal.screen().rows(), Not(Contains(HasSubstr("axis 1.1: "))))
        << rows_on(terminal);
    EXPECT_THAT(terminal.screen().unknown(), IsEmpty());
    EXPECT_EQ(terminal.screen().wrapped(), 0U) << rows_on(terminal);
    EXPECT_EQ(terminal.screen().scrolled(), 0U) << rows_on(terminal);
  }

 private:
  // With a long watchdog time, for busy machines.
  RunningService service_{"--clock realtime --axes 2 --config " VDRIVE_SOURCE_DIR
                          "/tests/data/patient.yaml"};
};

// 80,000 UU at 10,000 UU/s take 8 s: no line in the first second, then a line for seven.
TEST_F(ProgressOnATerminal, OfAMoveIsOneLineThatIsRewrittenAndRemoved) {
  PseudoTerminal move(kRowsOfProgress, 100, "move 1.1 80000 --velocity 10000");
  ASSERT_TRUE(move.wait_until(has_row("axis 1.1: at ", " s left"))) << rows_on(move);
  EXPECT_THAT(move.screen().rows(),
              Contains(HasSubstr(", target 7031.25 deg, 878.91 deg/s, about ")));
  const std::vector<std::string> before = move.screen().rows();
  ASSERT_TRUE(move.wait_until([&before](const Screen& screen) {
    return has_row("axis 1.1: at ")(screen) && screen.rows() != before;
  })) << "it is rewritten";
  EXPECT_EQ(move.wait(), 0) << rows_on(move);
  expect_no_progress(move);
  EXPECT_THAT(move.screen().rows(),
              Contains(AllOf(HasSubstr("1.1 "), HasSubstr("target reached"))));
}

TEST_F(ProgressOnATerminal, IsCutToTheWidthOfTheTerminal) {
  PseudoTerminal wait(kRowsOfProgress, 20, "wait 1.1 fault --timeout 60s");
  ASSERT_TRUE(wait.wait_until(has_row("axis 1.1: waiting.."))) << rows_on(wait);
  EXPECT_EQ(wait.screen().wrapped(), 0U) << rows_on(wait);
}

TEST_F(ProgressOnATerminal, OfAWaitNamesWhatItWaitsFor) {
  PseudoTerminal wait(kRowsOfProgress, 120, "wait 1.1 position > 5 --timeout 60s");
  EXPECT_TRUE(wait.wait_until(
      has_row("axis 1.1: waiting for position > 5 UU (0.44 deg), at 0.00 deg, 0.00 deg/s")))
      << rows_on(wait);
  wait.interrupt();
  EXPECT_EQ(wait.wait(), 130) << rows_on(wait);
  PseudoTerminal condition(kRowsOfProgress, 120, "wait 1.1 fault --timeout 60s");
  EXPECT_TRUE(condition.wait_until(
      has_row("axis 1.1: waiting for fault, at 0.00 deg, 0.00 deg/s, Operation")))
      << rows_on(condition);
  PseudoTerminal time(kRowsOfProgress, 120, "wait 3s");
  EXPECT_TRUE(time.wait_until(has_row("bench 1: waiting for 3 s of drive time: ")))
      << rows_on(time);
  EXPECT_EQ(time.wait(), 0);
}

TEST_F(ProgressOnATerminal, OfAnExpectationNamesWhatIsChecked) {
  PseudoTerminal expect(kRowsOfProgress, 120,
                        "expect 1.1 position == 0 --tolerance 2 --throughout 60s");
  EXPECT_TRUE(expect.wait_until(
      has_row("axis 1.1: checking position 0 UU (0.00 deg) +- 2 UU (0.18 deg), at 0.")))
      << rows_on(expect);
}

// The first axis brakes from 10,000 UU/s at 1,000 UU/s2, which takes 10 s; the second one is at
// rest.
TEST_F(ProgressOnATerminal, OfSeveralAxesCountsThoseThatAreDone) {
  ASSERT_EQ(tool("enable 1.2").code, 0);
  ASSERT_EQ(tool("move 1.2 10").code, 0);
  ASSERT_EQ(tool("velocity 1.1 10000 --deceleration 1000").code, 0);
  PseudoTerminal halt(kRowsOfProgress, 100, "halt --all --wait");
  EXPECT_TRUE(halt.wait_until(has_row("halt: 1 of 2 axes"))) << rows_on(halt);
  EXPECT_EQ(halt.wait(), 0) << rows_on(halt);
  EXPECT_FALSE(has_row("halt: ")(halt.screen())) << rows_on(halt);
}

TEST_F(ProgressOnATerminal, OfARecordingCountsSamples) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() / "a.csv";
  PseudoTerminal record(kRowsOfProgress, 100, "record " + file + " 1.1 --for 6s");
  EXPECT_TRUE(record.wait_until(has_row("recorded ", " %"))) << rows_on(record);
  EXPECT_EQ(record.wait(), 0) << rows_on(record);
  EXPECT_FALSE(has_row("recorded ")(record.screen())) << rows_on(record);
}

TEST_F(ProgressOnATerminal, IsNotShownWithJsonOnADumbTerminalOrInAPipe) {
  PseudoTerminal json(kRowsOfProgress, 100, "--json wait 2s");
  EXPECT_EQ(json.wait(), 0);
  EXPECT_THAT(json.output(), AllOf(Not(HasSubstr("waiting for")), Not(HasSubstr(kErasedRow))));
  PseudoTerminal dumb(kRowsOfProgress, 100, "wait 2s", {"TERM=dumb"});
  EXPECT_EQ(dumb.wait(), 0);
  EXPECT_THAT(dumb.output(), AllOf(Not(HasSubstr("waiting for")), Not(HasSubstr("\x1b"))));
  const Finished piped = tool("wait 2s");
  EXPECT_EQ(piped.code, 0);
  EXPECT_THAT(piped.errors, IsEmpty());
}

TEST_F(ProgressOnATerminal, IsRemovedWhenTheCommandIsInterrupted) {
  PseudoTerminal move(kRowsOfProgress, 100, "move 1.1 400000 --velocity 10000");
  ASSERT_TRUE(move.wait_until(has_row("axis 1.1: at "))) << rows_on(move);
  move.interrupt();
  EXPECT_EQ(move.wait(), 130);
  EXPECT_FALSE(has_row("axis 1.1: at ")(move.screen())) << rows_on(move);
}

TEST_F(ProgressOnATerminal, OfACommandThatEndsWithinASecondIsNotThere) {
  PseudoTerminal wait(kRowsOfProgress, 100, "wait 100ms");
  EXPECT_EQ(wait.wait(), 0);
  EXPECT_THAT(wait.output(), Not(HasSubstr("drive time")));
}

}  // namespace
}  // namespace vdrive::test
