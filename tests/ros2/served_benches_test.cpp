// SPDX-License-Identifier: Apache-2.0
#include "served_benches.hpp"

#include "fake_benches.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::ros2 {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

TEST(ServedBenches, FindsJointsByNameOnTheirBench) {
  FakeBenches fake;
  fake.add(1, {"x", "y"});
  fake.add(2, {"z"});
  fake.find();
  EXPECT_EQ(fake.benches.find_joint("y"), (JointPlace{.bench = 1, .place = 1}));
  EXPECT_EQ(fake.benches.find_joint("z"), (JointPlace{.bench = 2, .place = 0}));
  EXPECT_EQ(fake.benches.find_joint("a"), std::nullopt);
  EXPECT_THAT(fake.written.lines,
              ElementsAre("bench 1: found, 2 joints", "bench 2: found, 1 joints"));
}

TEST(ServedBenches, AreSearchedFiveTimesASecond) {
  FakeBenches fake;
  fake.find();
  fake.add(1, {"x"});
  fake.benches.find(fake.time + std::chrono::milliseconds(199));
  EXPECT_THAT(fake.benches.all(), IsEmpty());
  fake.benches.find(fake.time + std::chrono::milliseconds(200));
  EXPECT_THAT(fake.benches.all(), SizeIs(1));
}

TEST(ServedBenches, LeaveOutABenchWhoseJointsClashUntilTheNameIsFree) {
  FakeBenches fake;
  fake.add(1, {"x"});
  fake.find();
  fake.add(2, {"x"});
  fake.find();
  EXPECT_THAT(fake.benches.all(), SizeIs(1));
  EXPECT_THAT(fake.benches.views().at(2).problem, HasSubstr("its joint \"x\" is also on bench 1"));
  EXPECT_THAT(fake.benches.views().at(2).bench->joints(), IsEmpty()) << "it has no joints of ROS";
  fake.find();
  EXPECT_THAT(fake.written.lines, SizeIs(2)) << "what is left out is said once";
  fake.drives.erase(1);
  for (int second = 0; second < 61; ++second) fake.find();  // bench 1 is dropped after a minute
  EXPECT_EQ(fake.benches.find_joint("x")->bench, 2U);
  EXPECT_THAT(fake.benches.views().at(2).problem, IsEmpty());
}

TEST(ServedBenches, ReplaceABenchThatWasRestarted) {
  FakeBenches fake;
  fake.add(1, {"x"});
  fake.find();
  const BenchMotion* const before = &fake.motion();
  fake.drives.at(1).info().incarnation = 17;
  fake.find();
  EXPECT_THAT(fake.restarted, ElementsAre(before));
  EXPECT_EQ(fake.benches.all().at(1).bench->info().incarnation, 17U);
  // "found" is reported once: the second report repeats the text within a second.
  EXPECT_THAT(fake.written.lines, ElementsAre(HasSubstr("found"), "bench 1: was restarted"));
}

TEST(ServedBenches, TakeTheRateOfABenchInRealtimeAndKeepItWhileTheBenchIsPaused) {
  FakeBenches fake;
  fake.add(1, {"x"});
  fake.drives.at(1).info().clock_mode = ClockMode::realtime;
  const auto rate = [&fake](double published) {
    fake.drives.at(1).info().rate = published;
    fake.find();
    return fake.benches.all().at(1).bench->seen().rate;
  };
  EXPECT_EQ(rate(1.0), 1.0);
  EXPECT_EQ(rate(2.0), 2.0);
  EXPECT_EQ(rate(0.0), 2.0);
}

TEST(ServedBenches, AreEnabledWhenTheyComeIfTheSettingsSayIt) {
  Settings settings;
  settings.is_enabled = true;
  FakeBenches fake(settings);
  fake.add(1, {"x"});
  fake.find();
  EXPECT_TRUE(fake.benches.views().at(1).is_enabled);
  fake.benches.enable(false);
  EXPECT_FALSE(fake.benches.views().at(1).is_enabled);
  fake.add(2, {"y"});
  fake.find();
  EXPECT_FALSE(fake.benches.views().at(2).is_enabled) << "a person has switched them off since";
}

TEST(ServedBenches, HaveATimeAfterTheirFirstState) {
  FakeBenches fake;
  fake.add(1, {"x"});
  fake.find();
  EXPECT_EQ(fake.benches.time_of(1), std::nullopt);
  EXPECT_EQ(fake.benches.time_of(2), std::nullopt);
  fake.turn();
  EXPECT_EQ(fake.benches.time_of(1), 1'000'000'000) << "1,000 ticks of 1 ms, in lock-step";
  EXPECT_TRUE(fake.benches.any_in_lockstep());
}

}  // namespace
}  // namespace vdrive::ros2
