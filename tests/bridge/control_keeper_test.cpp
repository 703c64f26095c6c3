// SPDX-License-Identifier: Apache-2.0
#include "control_keeper.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace vdrive::bridge {
namespace {

using namespace std::chrono_literals;
using client::AxisSnapshot;
using client::Observation;
using client::Outcome;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::uint64_t kOwn = 0x0A;
constexpr std::uint64_t kOther = 0x0B;
constexpr ControlKeeper::Clock::time_point kKeeperBegin{1h};

/// A bench with two axes, and the keeper of their control.
struct Kept final : ControlledBench {
  std::vector<AxisSnapshot> axes{2};
  bool is_refused = false;
  int requests = 0;
  std::vector<std::string> reports{};
  ControlKeeper keeper{kOwn, *this, {.loss = "want it again", .faults = "reset them"}};

  Outcome acquire() override {
    ++requests;
    if (is_refused) return Outcome::refused(1, "the bench refuses");
    own(kOwn);
    return Outcome{};
  }

  std::optional<Observation> observe() override {
    Observation now;
    now.axes = axes;
    return now;
  }

  std::string name_of(std::uint64_t session) override {
    return "program " + std::to_string(session);
  }

  void report(Severity /*severity*/, const std::string& text) override { reports.push_back(text); }

  void own(std::uint64_t session) {
    for (AxisSnapshot& axis : axes) axis.owner_session = session;
  }

  bool keep(std::chrono::milliseconds time) {
    return keeper.keep(axes, kKeeperBegin + time).has_value();
  }
};

TEST(ControlKeeper, TakesWhatIsFreeOnceItIsWanted) {
  Kept kept;
  EXPECT_FALSE(kept.keep(0ms));
  kept.keeper.want(true);
  EXPECT_TRUE(kept.keep(0ms));
  EXPECT_TRUE(owns_all(kept.axes, kOwn));
  EXPECT_FALSE(kept.keep(10s)) << "it has what it wants";
  EXPECT_EQ(kept.requests, 1);
  EXPECT_THAT(kept.reports, IsEmpty()) << "nobody waited";
}

TEST(ControlKeeper, SendsNoRequestWhileAnotherSessionControlsAnAxis) {
  Kept kept;
  kept.axes[1].owner_session = kOther;
  kept.keeper.want(true);
  EXPECT_FALSE(kept.keep(0ms));
  EXPECT_FALSE(kept.keep(1s));
  EXPECT_EQ(kept.requests, 0);
  EXPECT_THAT(kept.reports, ElementsAre(HasSubstr("program 11 controls 1 of its 2 axes")))
      << "once";
  kept.own(0);
  EXPECT_TRUE(kept.keep(2s));
  EXPECT_THAT(kept.reports.back(),
              HasSubstr("taking control: program 11 no longer controls its axes"));
}

TEST(ControlKeeper, SaysWhichAxesAreInAFaultWhenItsWaitEnds) {
  Kept kept;
  kept.own(kOther);
  kept.keeper.want(true);
  (void)kept.keep(0ms);
  kept.own(0);
  kept.axes[0].status.ds402_statusword = 0x0008;  // Fault
  EXPECT_TRUE(kept.keep(1s));
  EXPECT_THAT(kept.reports.back(), HasSubstr("1 of 2 are in a fault: reset them"));
}

TEST(ControlKeeper, AsksMoreAndMoreRarelyAfterRefusals) {
  Kept kept;
  kept.is_refused = true;
  kept.keeper.want(true);
  for (auto time = 0ms; time < 10s; time += 10ms) (void)kept.keep(time);
  // At 0, 0.2, 0.6, 1.4, 3.0 s, then every 2 s.
  EXPECT_EQ(kept.requests, 8);
  EXPECT_THAT(kept.reports, ElementsAre(HasSubstr("cannot take control: the bench refuses")));
}

TEST(ControlKeeper, LeavesControlThatAnotherSessionTookUntilItIsWantedAgain) {
  Kept kept;
  kept.keeper.want(true);
  (void)kept.keep(0ms);
  kept.own(kOther);
  EXPECT_FALSE(kept.keep(1s));
  EXPECT_THAT(kept.reports,
              ElementsAre(HasSubstr("program 11 has taken control of its axes: want")));
  kept.own(0);
  EXPECT_FALSE(kept.keep(2s));
  EXPECT_EQ(kept.requests, 1);
  kept.keeper.want(true);
  EXPECT_TRUE(kept.keep(3s));
}

TEST(ControlKeeper, ReportsNoLossOfWhatIsNotWantedAnyMore) {
  Kept kept;
  kept.keeper.want(true);
  (void)kept.keep(0ms);
  kept.keeper.want(false);
  kept.own(kOther);
  EXPECT_FALSE(kept.keep(1s));
  EXPECT_THAT(kept.reports, IsEmpty());
}

}  // namespace
}  // namespace vdrive::bridge
