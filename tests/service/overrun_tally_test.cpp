// SPDX-License-Identifier: Apache-2.0
// Late ticks are summarised in a few events.
#include "clock/overrun_tally.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

/// Runs ticks at 1 kHz and collects the reports.
struct Ticks {
  /// @param late how long after its deadline each tick ends; negative = in time
  void run(std::chrono::milliseconds duration, std::chrono::microseconds late) {
    for (const auto end = now + duration; now < end; now += 1ms) {
      if (const auto report = tally.note(now, late)) reports.push_back(*report);
    }
  }

  OverrunTally tally;
  std::chrono::nanoseconds now = 1'000s;
  std::vector<Overruns> reports;
};

TEST(OverrunTally, SaysNothingOfTicksInTime) {
  Ticks ticks;
  ticks.run(10s, -200us);
  EXPECT_TRUE(ticks.reports.empty());
}

TEST(OverrunTally, ReportsTheFirstLateTickAtOnce) {
  Ticks ticks;
  ticks.run(1ms, 300us);
  ASSERT_EQ(ticks.reports.size(), 1U);
  EXPECT_EQ(ticks.reports[0], (Overruns{1, 300us, 0ms}));
}

TEST(OverrunTally, CountsThoseOfASpanAndKeepsTheWorst) {
  Ticks ticks;
  ticks.run(1ms, 300us);
  ticks.run(1ms, 900us);
  ticks.run(2ms, 100us);
  ticks.run(1s, -200us);
  ASSERT_EQ(ticks.reports.size(), 2U);
  // This report begins with the second late tick, 1 ms after the first one, and ends 1 s after the
  // first one: 999 ms.
  EXPECT_EQ(ticks.reports[1], (Overruns{3, 900us, 999ms}));
}

TEST(OverrunTally, DoublesTheSpanWhileTheyContinueUpToTheLongest) {
  Ticks ticks;
  ticks.run(300s, 100us);
  // Reports at 0, 1, 3, 7, 15, 31, 63, 127, 191 and 255 s.
  ASSERT_EQ(ticks.reports.size(), 10U);
  EXPECT_EQ(ticks.reports[1].count, 1'000U);
  EXPECT_EQ(ticks.reports[2].count, 2'000U);
  EXPECT_EQ(ticks.reports[8].count, 64'000U);
  EXPECT_EQ(ticks.reports[9].count, 64'000U);
}

TEST(OverrunTally, BeginsWithTheShortestSpanAfterALongQuietTime) {
  Ticks ticks;
  ticks.run(10s, 100us);  // reports at 0, 1, 3 and 7 s; the span of 8 s ends at 15 s
  ticks.run(40s, -100us);
  ASSERT_EQ(ticks.reports.size(), 5U) << "those of 7 to 10 s";
  ticks.run(1ms, 100us);
  EXPECT_EQ(ticks.reports.size(), 6U) << "at once: the span of 16 s ended at 31 s, 19 s ago";
  ticks.run(1s, 100us);
  EXPECT_EQ(ticks.reports.size(), 7U);
}

TEST(OverrunTally, TellsAtAPauseWhatIsLeft) {
  OverrunTally tally;
  EXPECT_TRUE(tally.note(1ms, 300us));
  EXPECT_FALSE(tally.note(2ms, 900us));
  EXPECT_FALSE(tally.note(3ms, 100us));
  EXPECT_EQ(tally.flush(3ms), (Overruns{2, 900us, 1ms}));
  EXPECT_EQ(tally.flush(4ms), std::nullopt);
}

}  // namespace
}  // namespace vdrive::service
