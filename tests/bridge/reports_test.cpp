// SPDX-License-Identifier: Apache-2.0
#include "reports.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace vdrive::bridge {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::Optional;

constexpr ReportLimit::Clock::time_point kReportsBegin{1h};

TEST(ReportLimit, LeavesOutAnEqualTextForASecond) {
  ReportLimit limit;
  EXPECT_THAT(limit.line_of("bench 1", "is late", kReportsBegin),
              Optional(std::string("bench 1: is late")));
  EXPECT_FALSE(limit.line_of("bench 1", "is late", kReportsBegin + 999ms));
  EXPECT_TRUE(limit.line_of("bench 2", "is late", kReportsBegin + 999ms)) << "another subject";
  EXPECT_THAT(limit.line_of("bench 1", "is late", kReportsBegin + 1s),
              Optional(std::string("bench 1: is late (1 earlier suppressed)")));
  EXPECT_THAT(limit.line_of("bench 1", "is late", kReportsBegin + 2s),
              Optional(std::string("bench 1: is late")))
      << "it counts from the last line";
}

TEST(ReportLimit, LetsTenTextsOfASubjectThroughAtOnceAndThenFiveASecond) {
  ReportLimit limit;
  int lines = 0;
  for (int i = 0; i < 50; ++i) {
    lines += limit.line_of("joints", "text " + std::to_string(i), kReportsBegin) ? 1 : 0;
  }
  EXPECT_EQ(lines, 10);
  EXPECT_THAT(limit.line_of("joints", "later", kReportsBegin + 200ms),
              Optional(std::string("joints: later (40 earlier suppressed)")));
  EXPECT_FALSE(limit.line_of("joints", "at once", kReportsBegin + 200ms));
}

TEST(ReportLimit, WritesControlCharactersAsTheirCodes) {
  ReportLimit limit;
  EXPECT_THAT(limit.line_of("joint \x1B[2J", "moves", kReportsBegin),
              Optional(std::string("joint \\x1B[2J: moves")));
}

TEST(Reports, HandEachLineToTheBridge) {
  std::vector<std::string> lines;
  Reports reports("vdrive-test", [&lines](Severity severity, const std::string& line) {
    EXPECT_EQ(severity, Severity::warning);
    lines.push_back(line);
  });
  testing::internal::CaptureStderr();
  reports.report(Severity::warning, "bench 1", "is late");
  reports.report(Severity::warning, "bench 1", "is late");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "vdrive-test: warning: bench 1: is late\n");
  EXPECT_THAT(lines, ElementsAre("bench 1: is late"));
}

}  // namespace
}  // namespace vdrive::bridge
