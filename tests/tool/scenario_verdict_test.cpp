// SPDX-License-Identifier: Apache-2.0
// The verdict of `vdrive test` on the outcome of `vdrive run --json`, without a process.
#include "scenarios/scenario_verdict.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::tool {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

/// A file with commands in lines 2 and 4.
Scenario scenario_of_two_lines() {
  Scenario scenario{.file = "lift.scn", .lines = {}, .variables = {}};
  scenario.lines.resize(2);
  scenario.lines[0].number = 2;
  scenario.lines[0].text = "enable 1.1";
  scenario.lines[1].number = 4;
  scenario.lines[1].text = "move 1.1 100";
  return scenario;
}

TEST(ScenarioVerdict, HasACaseForEachLineWithItsTime) {
  const ScenarioVerdict sut =
      verdict_of(scenario_of_two_lines(), {.code = 0,
                                           .output = R"({"line":2,"outcome":"ok","seconds":0.5})"
                                                     "\n"
                                                     R"({"line":4,"outcome":"ok","seconds":0.25})"
                                                     "\n",
                                           .errors = ""});

  EXPECT_EQ(sut.code, 0);
  EXPECT_EQ(sut.suite.name, "lift.scn");
  ASSERT_EQ(sut.suite.cases.size(), 2U);
  EXPECT_EQ(sut.suite.cases[0].name, "line 2: enable 1.1");
  EXPECT_EQ(sut.suite.cases[0].duration, 500ms);
  EXPECT_EQ(sut.suite.cases[1].name, "line 4: move 1.1 100");
  EXPECT_FALSE(sut.suite.cases[1].is_skipped);
}

// For example a pipe, which is empty when the process that runs the file reads it.
TEST(ScenarioVerdict, FailsAFileWhoseLinesDidNotAllRun) {
  for (const std::string output : {R"({"line":2,"outcome":"ok"})", ""}) {
    const ScenarioVerdict sut =
        verdict_of(scenario_of_two_lines(), {.code = 0, .output = output, .errors = ""});

    EXPECT_EQ(sut.code, 1);
    ASSERT_EQ(sut.messages.size(), 1U);
    EXPECT_THAT(sut.messages.front(), testing::HasSubstr("lift.scn: has changed since it"));
    EXPECT_TRUE(sut.suite.cases.back().error) << "in the report, too";
  }
}

TEST(ScenarioVerdict, SkipsTheLinesAfterAFailure) {
  const ScenarioVerdict sut = verdict_of(
      scenario_of_two_lines(), {.code = 5,
                                .output = R"({"line":2,"outcome":"refused","message":"not yours"})",
                                .errors = "vdrive: not yours\n"});

  EXPECT_EQ(sut.code, 5);
  EXPECT_THAT(sut.messages, ElementsAre("vdrive: not yours"));
  ASSERT_EQ(sut.suite.cases.size(), 2U);
  EXPECT_EQ(sut.suite.cases[0].failure, "not yours");
  EXPECT_TRUE(sut.suite.cases[1].is_skipped);
}

TEST(ScenarioVerdict, HasEverythingThatIsKnownOfAFailure) {
  const ScenarioVerdict sut = verdict_of(
      scenario_of_two_lines(),
      {.code = 1,
       .output =
           "1.1 mode = 1\n"
           R"({"line":2,"outcome":"ok","seconds":0.5})"
           "\n"
           R"({"line":4,"outcome":"failed","message":"expected 1","type":"expectation","tick":9,)"
           R"("details":["axis 1.1 at tick 9: 0x637"],"advice":"look"})",
       .errors = ""});

  ASSERT_EQ(sut.suite.cases.size(), 2U);
  EXPECT_EQ(sut.suite.cases[0].line, 2U);
  EXPECT_EQ(sut.suite.cases[0].output, "1.1 mode = 1\n");
  EXPECT_EQ(sut.suite.cases[1].line, 4U);
  EXPECT_EQ(sut.suite.cases[1].type, "expectation");
  EXPECT_EQ(sut.suite.cases[1].failure, "expected 1");
  EXPECT_EQ(sut.suite.cases[1].text,
            "lift.scn:4: move 1.1 100: expected 1\n  axis 1.1 at tick 9: 0x637\n  next: look");
  EXPECT_EQ(sut.suite.cases[1].output, "");
}

TEST(ScenarioVerdict, CountsTheLinesThatWereDone) {
  const ScenarioVerdict sut = verdict_of(
      scenario_of_two_lines(),
      {.code = 1, .output = R"({"line":2,"outcome":"failed","message":"no"})", .errors = ""});
  EXPECT_EQ(sut.done, 1U);
  EXPECT_EQ(lines_text(sut.done, 2), "1 of 2 lines done");
  EXPECT_EQ(lines_text(2, 2), "2 lines");
  EXPECT_EQ(lines_text(0, 1), "0 of 1 line done");
}

TEST(ScenarioVerdict, KeepsTheEndOfWhatAStreamPrinted) {
  std::string output;
  for (int i = 0; i < 102; ++i) output += "sample " + std::to_string(i) + "\n";
  const ScenarioVerdict sut =
      verdict_of(scenario_of_two_lines(),
                 {.code = 0, .output = output + R"({"line":2,"outcome":"ok"})", .errors = ""});
  EXPECT_THAT(sut.suite.cases[0].output,
              testing::AllOf(testing::StartsWith("(2 lines omitted)\nsample 2\n"),
                             testing::EndsWith("sample 101\n")));
}

TEST(ScenarioVerdict, TakesNoOutputOfACommandForAResult) {
  const std::string printed = "no JSON\n[2]\n{\"line\":4}\n{\"outcome\":\"refused\"}\n";
  const ScenarioVerdict sut =
      verdict_of(scenario_of_two_lines(), {.code = 0,
                                           .output = R"({"line":2,"outcome":"ok"})"
                                                     "\n" +
                                                     printed + R"({"line":4,"outcome":"ok"})",
                                           .errors = ""});

  EXPECT_EQ(sut.code, 0);
  ASSERT_EQ(sut.suite.cases.size(), 2U);
  for (const JunitCase& test : sut.suite.cases) EXPECT_FALSE(test.is_skipped || test.failure);
  EXPECT_EQ(sut.suite.cases[1].output, printed);
}

// The kernel kills processes when memory runs out, which says nothing about the file.
TEST(ScenarioVerdict, NamesTheSignalThatEndedTheProcess) {
  const ScenarioVerdict sut =
      verdict_of(scenario_of_two_lines(), {.code = -9, .output = "", .errors = "first\n"});

  EXPECT_EQ(sut.code, static_cast<int>(ExitCode::not_run));
  EXPECT_THAT(sut.messages, ElementsAre("first", "ended by signal 9"));
  ASSERT_EQ(sut.suite.cases.size(), 1U);  // no line was run: the start itself is the case
  EXPECT_EQ(sut.suite.cases[0].name, "start");
  EXPECT_EQ(sut.suite.cases[0].error, "ended by signal 9");
  EXPECT_EQ(sut.suite.cases[0].type, "not_run");
}

TEST(ScenarioVerdict, HasACaseForACrashAfterTheFirstLine) {
  const ScenarioVerdict sut = verdict_of(
      scenario_of_two_lines(),
      {.code = -11, .output = R"({"line":2,"outcome":"ok","seconds":0.5})", .errors = ""});

  EXPECT_EQ(sut.code, static_cast<int>(ExitCode::failed));
  ASSERT_EQ(sut.suite.cases.size(), 3U);
  EXPECT_FALSE(sut.suite.cases[0].is_skipped);
  EXPECT_TRUE(sut.suite.cases[1].is_skipped);
  EXPECT_EQ(sut.suite.cases[2].name, "end");
  EXPECT_EQ(sut.suite.cases[2].error, "ended by signal 11");
}

TEST(ScenarioVerdict, HasACaseForAFailureOutsideAnyLine) {
  const ScenarioVerdict sut =
      verdict_of(scenario_of_two_lines(), {.code = 1,
                                           .output = R"({"line":2,"outcome":"ok"})"
                                                     "\n"
                                                     R"({"line":4,"outcome":"ok"})",
                                           .errors = "vdrive: release: lost\n"});

  ASSERT_EQ(sut.suite.cases.size(), 3U);
  EXPECT_EQ(sut.suite.cases[2].name, "end");
  EXPECT_EQ(sut.suite.cases[2].error, "vdrive: release: lost");
}

TEST(ScenarioVerdict, IsInterruptedUntilTheScenarioHasRun) {
  const ScenarioVerdict sut = not_started(scenario_of_two_lines());

  EXPECT_EQ(sut.code, static_cast<int>(ExitCode::interrupted));
  EXPECT_THAT(sut.messages, IsEmpty());
  ASSERT_EQ(sut.suite.cases.size(), 1U);
  EXPECT_TRUE(sut.suite.cases[0].is_skipped);
}

}  // namespace
}  // namespace vdrive::tool
