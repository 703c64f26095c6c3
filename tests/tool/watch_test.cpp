// SPDX-License-Identifier: Apache-2.0
// `vdrive watch` and the live view of `vdrive run`, on terminals of several sizes.
#include "support/temporary_directory.hpp"
#include "tool/process.hpp"
#include "tool/pseudo_terminal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

namespace vdrive::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

constexpr std::size_t kRows = 24;
constexpr int kRed = 31;

/// Whether there is a title, a header and a row for each of three axes, with nothing below.
bool shows_three_axes(const Screen& screen) {
  const std::vector<std::string> rows = screen.rows();
  return rows[0].starts_with("tick ") && rows[1].starts_with("axis") &&
         rows[2].starts_with("1.1") && rows[3].starts_with("1.2") && rows[4].starts_with("1.3") &&
         rows[5].empty();
}

std::string error_of(const Screen& screen) {
  return "screen:\n" + testing::PrintToString(screen.rows());
}

/// Three axes in lock-step; the first makes a long move.
class WatchOnATerminal : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(tool("enable 1.1").code, 0);
    ASSERT_EQ(tool("move 1.1 1000000 --no-wait").code, 0);
  }

  /// Steps the axes until the table shows another tick.
  static bool see_another_tick(PseudoTerminal& watch) {
    const std::string before = watch.screen().rows()[0];
    return tool("step 20").code == 0 && watch.wait_until([&](const Screen& screen) {
      return shows_three_axes(screen) && screen.rows()[0] != before;
    });
  }

  static void expect_sound(const PseudoTerminal& watch) {
    EXPECT_EQ(watch.screen().scrolled(), 0U) << error_of(watch.screen());
    EXPECT_EQ(watch.screen().wrapped(), 0U) << error_of(watch.screen());
    EXPECT_THAT(watch.screen().unknown(), IsEmpty());
  }

 private:
  RunningService service_{"--clock lockstep --axes 3"};
};

TEST_F(WatchOnATerminal, ShowsEachAxisOnOneRowAtAnyWidth) {
  for (const std::size_t columns : {60U, 80U, 200U}) {
    PseudoTerminal watch(kRows, columns, "watch 1.1 1.2 1.3");
    ASSERT_TRUE(watch.wait_until(shows_three_axes)) << columns << error_of(watch.screen());
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(see_another_tick(watch)) << columns << error_of(watch.screen());
    }
    expect_sound(watch);
    const std::vector<std::string> rows = watch.screen().rows();
    EXPECT_THAT(rows[1], AllOf(HasSubstr("position"), HasSubstr("velocity"), HasSubstr("state")));
    EXPECT_THAT(rows[2], HasSubstr("Operation enabled")) << columns;
    EXPECT_THAT(rows[3], HasSubstr("Switch on disabled")) << columns;
    EXPECT_EQ(rows[1].find("word") != std::string::npos, columns >= 90) << rows[1];
    EXPECT_EQ(rows[1].find("demand") != std::string::npos, columns >= 160) << rows[1];
    EXPECT_EQ(rows[3].find("axis2") != std::string::npos, columns >= 100) << rows[3];
  }
}

TEST_F(WatchOnATerminal, FollowsTheSizeOfTheTerminal) {
  PseudoTerminal watch(kRows, 200, "watch 1.1 1.2 1.3");
  ASSERT_TRUE(watch.wait_until(shows_three_axes)) << error_of(watch.screen());
  // Time stands still, so only the new size can cause a redraw.
  for (const std::size_t columns : {60U, 80U, 40U, 200U}) {
    watch.resize(kRows, columns);
    ASSERT_TRUE(watch.wait_until([&](const Screen& screen) {
      const bool has_word = screen.rows()[1].find("word") != std::string::npos;
      const bool has_demand = screen.rows()[1].find("demand") != std::string::npos;
      return shows_three_axes(screen) && has_word == (columns >= 90) &&
             has_demand == (columns >= 160);
    })) << columns
        << error_of(watch.screen());
    // A table that was being sent at the old width wraps, and a part of it may have looked like the
    // new one. A table drawn after a step does not wrap.
    ASSERT_TRUE(see_another_tick(watch)) << columns << error_of(watch.screen());
    const std::size_t wrapped = watch.screen().wrapped();
    ASSERT_TRUE(see_another_tick(watch)) << columns << error_of(watch.screen());
    EXPECT_EQ(watch.screen().wrapped(), wrapped) << columns << error_of(watch.screen());
  }
  EXPECT_EQ(watch.screen().scrolled(), 0U) << error_of(watch.screen());
  EXPECT_THAT(watch.screen().unknown(), IsEmpty());
}

TEST_F(WatchOnATerminal, ShowsAFaultWithItsCodeItsNameAndAColor) {
  PseudoTerminal watch(kRows, 60, "watch 1.1 1.2 1.3");
  PseudoTerminal without_color(kRows, 60, "watch 1.1 1.2 1.3", {"NO_COLOR=1"});
  ASSERT_TRUE(watch.wait_until(shows_three_axes)) << error_of(watch.screen());
  EXPECT_NE(watch.screen().color_of_row(2), kRed);
  ASSERT_EQ(tool("disturb 1.1 over_current").code, 0);
  ASSERT_EQ(tool("step 5").code, 0);
  const auto shows_fault = [](const Screen& screen) {
    return screen.rows()[2].find("Fault 0x2310") != std::string::npos;
  };
  ASSERT_TRUE(watch.wait_until(shows_fault)) << error_of(watch.screen());
  EXPECT_THAT(watch.screen().rows()[2], HasSubstr("0x2310 continuous"));
  EXPECT_EQ(watch.screen().color_of_row(2), kRed);
  EXPECT_NE(watch.screen().color_of_row(3), kRed);
  ASSERT_TRUE(without_color.wait_until(shows_fault)) << error_of(without_color.screen());
  EXPECT_THAT(without_color.output(), Not(HasSubstr("\x1b[31m")));
  EXPECT_THAT(without_color.output(), Not(HasSubstr("\x1b[1m")));
}

TEST_F(WatchOnATerminal, LeavesTheLastTableOnTheNormalScreen) {
  PseudoTerminal watch(kRows, 80, "watch 1.1 1.2 1.3");
  ASSERT_TRUE(watch.wait_until(shows_three_axes)) << error_of(watch.screen());
  EXPECT_TRUE(watch.screen().is_alternate());
  EXPECT_FALSE(watch.screen().shows_cursor());
  watch.interrupt();
  EXPECT_EQ(watch.wait(), 130);
  EXPECT_FALSE(watch.screen().is_alternate());
  EXPECT_TRUE(watch.screen().shows_cursor());
  EXPECT_THAT(watch.screen().rows(), Contains(StartsWith("1.3")));
}

TEST_F(WatchOnATerminal, CountsTheAxesThatDoNotFit) {
  // Four rows: title, header, one axis, and a row that counts two more.
  PseudoTerminal watch(4, 60, "watch 1.1 1.2 1.3");
  ASSERT_TRUE(watch.wait_until([](const Screen& screen) {
    return screen.rows()[3] == "... 2 more axes";
  })) << error_of(watch.screen());
  EXPECT_THAT(watch.screen().rows()[2], StartsWith("1.1"));
  expect_sound(watch);
}

TEST_F(WatchOnATerminal, SortsFiltersPagesAndEndsByKeys) {
  for (const std::size_t columns : {60U, 80U, 200U}) {
    PseudoTerminal watch(kRows, columns, "watch");
    ASSERT_TRUE(watch.wait_until(shows_three_axes)) << error_of(watch.screen());
    const auto shows_in_third_row = [&watch](const std::string& text) {
      return watch.wait_until([&text](const Screen& screen) {
        return screen.rows()[2].starts_with(text);
      });
    };
    watch.type("r");
    EXPECT_TRUE(shows_in_third_row("1.3")) << columns << error_of(watch.screen());
    watch.type("r");
    EXPECT_TRUE(shows_in_third_row("1.1")) << columns << error_of(watch.screen());
    watch.type("f");
    EXPECT_TRUE(shows_in_third_row("no axis has a fault")) << columns << error_of(watch.screen());
    expect_sound(watch);
    watch.type("q");
    EXPECT_EQ(watch.wait(), 0);
    EXPECT_FALSE(watch.screen().is_alternate());
  }
}

TEST_F(WatchOnATerminal, ShowsTheNextPageOnALowTerminal) {
  PseudoTerminal watch(4, 60, "watch");
  ASSERT_TRUE(watch.wait_until([](const Screen& screen) {
    return screen.rows()[2].starts_with("1.1") && screen.rows()[3] == "... 2 more axes";
  })) << error_of(watch.screen());
  watch.type("\x1b[6~");
  EXPECT_TRUE(watch.wait_until([](const Screen& screen) {
    return screen.rows()[2].starts_with("1.2");
  })) << error_of(watch.screen());
  expect_sound(watch);
}

TEST_F(WatchOnATerminal, SendsNoEscapesToADumbTerminal) {
  EXPECT_THAT(tool("watch 1.1 1.2 1.3 --count 1").output, Not(HasSubstr("\x1b")));
  PseudoTerminal dumb(kRows, 200, "watch 1.1 1.2 1.3", {"TERM=dumb"});
  ASSERT_TRUE(dumb.wait_until([](const Screen& screen) {
    return screen.rows()[2].find("1.3") != std::string::npos;
  })) << error_of(dumb.screen());
  EXPECT_THAT(dumb.output(), Not(HasSubstr("\x1b")));
}

// The lines of a scenario stay; the live block below them has one row per axis.
TEST_F(WatchOnATerminal, KeepsTheLinesOfARunAndOneRowForEachAxis) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() / "far.scn";
  std::ofstream(file) << "enable 1.2\nmove 1.2 20000 --velocity 20000\nmove 1.2 0\n";
  PseudoTerminal run(kRows, 60, "run " + file);
  EXPECT_EQ(run.wait(), 0) << error_of(run.screen());
  EXPECT_EQ(run.screen().wrapped(), 0U) << error_of(run.screen());
  std::vector<std::string> rows = run.screen().rows();
  EXPECT_THAT(rows, Contains(HasSubstr("move 1.2 20000")));
  EXPECT_THAT(rows, Contains(HasSubstr("move 1.2 0")));
  EXPECT_THAT(rows, Contains(StartsWith("passed")));
  const auto live = std::ranges::count_if(rows, [](const std::string& row) {
    return row.find(" UU") != std::string::npos;
  });
  EXPECT_EQ(live, 1) << error_of(run.screen());
}

/// The first bench is paused, the second one runs.
class WatchOfTwoBenches : public testing::Test {
 private:
  RunningService standing_{"--clock lockstep --bench 1"};
  RunningService running_{"--clock realtime --bench 2"};
};

TEST_F(WatchOfTwoBenches, IsOneTableWithTheTickOfEach) {
  PseudoTerminal watch(kRows, 120, "watch");
  const auto shows_all = [](const Screen& screen) {
    const std::vector<std::string> rows = screen.rows();
    return rows[0].starts_with("bench 1 tick 0, bench 2 tick ") && rows[2].starts_with("1.1") &&
           rows[3].starts_with("1.2") && rows[4].starts_with("2.1") && rows[5].starts_with("2.2") &&
           rows[6].empty();
  };
  ASSERT_TRUE(watch.wait_until(shows_all)) << error_of(watch.screen());
  EXPECT_THAT(watch.screen().rows()[1], HasSubstr("bench"));
  const std::string before = watch.screen().rows()[0];
  EXPECT_TRUE(watch.wait_until([&](const Screen& screen) {
    return shows_all(screen) && screen.rows()[0] != before;
  })) << error_of(watch.screen());
  EXPECT_EQ(watch.screen().wrapped(), 0U);
}

TEST_F(WatchOfTwoBenches, PrintsLinesOfBothInAPipe) {
  EXPECT_EQ(tool("watch 1.* 2.1 --count 2 --json").lines().size(), 6U);
  EXPECT_EQ(tool("watch --count 1").lines().size(), 4U);
}

}  // namespace
}  // namespace vdrive::test
