// SPDX-License-Identifier: Apache-2.0
#include "bench_power.hpp"

#include "fake_bench.hpp"
#include "vdrive/cia402/standing_targets.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdrive::ros2 {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr BenchPower::Clock::time_point kPowerBegin{1h};

/// A bench with two axes controlled by the bridge, and their BenchPower.
struct Powered {
  FakeBench drives{{"x", "y"}};
  Bench bench{drives.info(), drives.joints()};
  WrittenReports written{};
  BenchPower power{FakeBench::kSession, bench, written.reports};

  Powered() {
    drives.axis(0).owner_session = FakeBench::kSession;
    drives.axis(1).owner_session = FakeBench::kSession;
  }

  client::Observation state() {
    drives.link(bench);
    return *bench.seen().state;
  }

  BenchPower::Frames words(std::chrono::milliseconds time = 0ms) {
    return power.words(state(), kPowerBegin + time);
  }
};

/// @return the controlwords for an axis, frame by frame.
std::vector<std::uint16_t> words_of(const BenchPower::Frames& frames, std::uint16_t axis) {
  std::vector<std::uint16_t> words;
  for (const client::SetPointFrame& frame : frames) {
    for (const client::SetPoint& point : frame.axes) {
      if (point.axis == axis) words.push_back(point.controlword.value());
    }
  }
  return words;
}

/// @return the modes (6060h) sent along with the controlwords of an axis; 0 = none.
std::vector<int> modes_of(const BenchPower::Frames& frames, std::uint16_t axis) {
  std::vector<int> modes;
  for (const client::SetPointFrame& frame : frames) {
    for (const client::SetPoint& point : frame.axes) {
      if (point.axis == axis) modes.push_back(point.mode ? static_cast<int>(*point.mode) : 0);
    }
  }
  return modes;
}

TEST(BenchPower, SendsTheWordsThatEachAxisNeedsOnceItControlsAll) {
  Powered bench;
  bench.power.want_enabled(true, false);
  bench.drives.axis(1).owner_session = 0;
  EXPECT_THAT(bench.words(), IsEmpty()) << "y is not under control yet";
  EXPECT_THAT(bench.drives.control_wishes(), ElementsAre(ControlWish::take));
  bench.drives.axis(1).owner_session = FakeBench::kSession;
  bench.drives.show(1, PowerState::switched_on);
  const auto frames = bench.words();
  EXPECT_THAT(words_of(frames, 1), ElementsAre(0x06, 0x07, 0x0F));
  EXPECT_THAT(words_of(frames, 2), ElementsAre(0x0F));
}

TEST(BenchPower, RepeatsTheWordsInALaterTickUntilTheAxesAreEnabled) {
  Powered bench;
  bench.power.want_enabled(true, false);
  EXPECT_THAT(bench.words(), SizeIs(3));
  bench.drives.step();
  EXPECT_THAT(bench.words(499ms), IsEmpty());
  EXPECT_THAT(bench.words(500ms), SizeIs(3));
  EXPECT_THAT(bench.words(2s), IsEmpty()) << "the bench has not passed a tick since";
  bench.drives.enable();
  bench.drives.step();
  EXPECT_THAT(bench.words(3s), IsEmpty());
}

TEST(BenchPower, GivesUpAfterTenAttemptsAndReportsIt) {
  Powered bench;
  bench.power.want_enabled(true, false);
  for (int attempt = 0; attempt < 10; ++attempt) {
    EXPECT_THAT(bench.words(attempt * 500ms), SizeIs(3)) << attempt;
    bench.drives.step();
  }
  EXPECT_THAT(bench.words(5s), IsEmpty());
  EXPECT_THAT(bench.written.lines, ElementsAre("bench 1: its axes cannot be enabled"));
}

TEST(BenchPower, ResetsAFaultOnlyWhereThatIsWantedAndOnce) {
  Powered bench;
  bench.drives.enable();
  bench.drives.show(0, PowerState::fault);
  bench.power.want_enabled(true, false);
  EXPECT_THAT(bench.words(), IsEmpty());
  bench.power.want_enabled(true, true);
  EXPECT_THAT(words_of(bench.words(), 1), ElementsAre(0x80, 0x06, 0x07, 0x0F));
  bench.drives.step();
  EXPECT_THAT(bench.words(1s), IsEmpty()) << "the axis is in a fault again";
}

TEST(BenchPower, ContinuesAfterAQuickStopWithItsPower) {
  Powered bench;
  bench.drives.enable();
  bench.drives.show(1, PowerState::quick_stop_active);
  bench.power.want_enabled(true, false);
  EXPECT_THAT(words_of(bench.words(), 2), ElementsAre(0x0F));
}

// Habit e of docs/guides/be-another-drive.md: the drive refuses a change of mode once it has power.
TEST(BenchPower, WritesTheModeOfEachJointBeforeItsPower) {
  FakeBench drives({"x", "y"});
  std::vector<ServedJoint> joints = drives.joints();
  joints[1].interface = CommandInterface::velocity;
  Bench bench(drives.info(), joints);
  WrittenReports written;
  BenchPower power(FakeBench::kSession, bench, written.reports);
  for (std::size_t place = 0; place < 2; ++place) {
    drives.axis(place).owner_session = FakeBench::kSession;
  }
  drives.show(1, PowerState::fault);
  power.want_enabled(true, true);
  drives.link(bench);
  const auto frames = power.words(*bench.seen().state, kPowerBegin);
  EXPECT_THAT(words_of(frames, 1), ElementsAre(0x06, 0x07, 0x0F));
  EXPECT_THAT(modes_of(frames, 1), ElementsAre(0, 0, 8)) << "a joint without an interface";
  EXPECT_THAT(words_of(frames, 2), ElementsAre(0x80, 0x06, 0x07, 0x0F));
  EXPECT_THAT(modes_of(frames, 2), ElementsAre(0, 0, 0, 9)) << "not in the fault";
  EXPECT_THAT(frames[2].axes[0].objects, SizeIs(7))
      << "60C2h:01, three offsets and the targets that an axis would follow at once";
}

// In every state, even if the axis keeps a mode set by another program.
TEST(BenchPower, LetsAnAxisRestThatGetsItsPower) {
  for (const PowerState from :
       {PowerState::switch_on_disabled, PowerState::ready_to_switch_on, PowerState::switched_on,
        PowerState::quick_stop_active, PowerState::fault}) {
    SCOPED_TRACE(to_string(from));
    Powered bench;
    bench.drives.show(0, from);
    bench.drives.show(1, from);
    bench.power.want_enabled(true, true);
    const auto frames = bench.words();
    ASSERT_FALSE(frames.empty());
    for (const client::SetPoint& point : frames.back().axes) {
      ASSERT_EQ(point.controlword, 0x0F);
      for (const ObjectAddress target : kStandingTargets) {
        const auto written = std::ranges::find(point.objects, target, &client::ObjectValue::object);
        ASSERT_NE(written, point.objects.end());
        EXPECT_EQ(written->value, 0);
      }
    }
  }
}

TEST(BenchPower, LeavesTheModeOfAnAxisThatMayStillBrake) {
  Powered bench;
  bench.drives.enable();
  bench.drives.show(1, PowerState::quick_stop_active);
  bench.power.want_enabled(true, false);
  EXPECT_THAT(modes_of(bench.words(), 2), ElementsAre(0));
  bench.drives.step();
  EXPECT_THAT(modes_of(bench.words(500ms), 2), ElementsAre(0, 0, 0, 8)) << "without its power";
}

TEST(BenchPower, TakesTheWayWithoutPowerWhereADriveHasNoTransition16) {
  Powered bench;
  bench.drives.enable();
  bench.drives.show(1, PowerState::quick_stop_active);
  bench.power.want_enabled(true, false);
  EXPECT_THAT(words_of(bench.words(), 2), ElementsAre(0x0F));
  bench.drives.step();
  bench.drives.axis(1).status.velocity_demand_value = 100;
  EXPECT_THAT(words_of(bench.words(500ms), 2), ElementsAre(0x0F)) << "it still brakes";
  bench.drives.step();
  bench.drives.axis(1).status.velocity_demand_value = 0;
  EXPECT_THAT(words_of(bench.words(1s), 2), ElementsAre(0x00, 0x06, 0x07, 0x0F));
}

// Habit c of docs/guides/be-another-drive.md; habit d, a drive without transition 16, is above.
TEST(BenchPower, EnablesADriveWhoseQuickStopEndsBeforeItsWord) {
  Powered bench;
  bench.drives.enable();
  bench.drives.show(1, PowerState::quick_stop_active);
  bench.power.want_enabled(true, false);
  EXPECT_THAT(words_of(bench.words(), 2), ElementsAre(0x0F));
  bench.drives.show(1, PowerState::switch_on_disabled);
  bench.drives.step();
  EXPECT_THAT(words_of(bench.words(500ms), 2), ElementsAre(0x06, 0x07, 0x0F));
}

// Habit f: of several controlwords received in one tick, the drive sees only the last one.
TEST(BenchPower, LeavesAFaultToAPersonWhereADriveHasNotSeenTheReset) {
  Powered bench;
  bench.drives.enable();
  bench.drives.show(0, PowerState::fault);
  bench.power.want_enabled(true, true);
  EXPECT_THAT(words_of(bench.words(), 1), ElementsAre(0x80, 0x06, 0x07, 0x0F));
  for (int attempt = 1; attempt <= 10; ++attempt) {
    bench.drives.step();
    EXPECT_THAT(bench.words(attempt * 500ms), IsEmpty()) << attempt;
  }
}

// Habit g: the drive stays in Switched on until its power stage is on.
TEST(BenchPower, RepeatsOnlyTheLastWordWhileThePowerOfADriveIsOnItsWay) {
  Powered bench;
  bench.power.want_enabled(true, false);
  EXPECT_THAT(bench.words(), SizeIs(3));
  bench.drives.show(0, PowerState::switched_on);
  bench.drives.show(1, PowerState::switched_on);
  bench.drives.step();
  EXPECT_THAT(bench.words(300ms), IsEmpty());
  const auto frames = bench.words(500ms);
  EXPECT_THAT(words_of(frames, 1), ElementsAre(0x0F)) << "no word takes the last one back";
  EXPECT_THAT(words_of(frames, 2), ElementsAre(0x0F));
  bench.drives.enable();
  bench.drives.step();
  EXPECT_THAT(bench.words(1s), IsEmpty());
  EXPECT_THAT(bench.written.lines, IsEmpty());
}

// Habit i: the words after the reset arrive during the fault, in which they are ignored.
TEST(BenchPower, EnablesADriveThatResetsItsFaultLate) {
  Powered bench;
  bench.drives.enable();
  bench.drives.show(0, PowerState::fault);
  bench.power.want_enabled(true, true);
  EXPECT_THAT(words_of(bench.words(), 1), ElementsAre(0x80, 0x06, 0x07, 0x0F));
  bench.drives.step();
  EXPECT_THAT(bench.words(20ms), IsEmpty()) << "it still shows the fault";
  bench.drives.show(0, PowerState::switch_on_disabled);
  bench.drives.step();
  EXPECT_THAT(words_of(bench.words(500ms), 1), ElementsAre(0x06, 0x07, 0x0F));
}

TEST(BenchPower, DisablesWhatItHasEnabledAndThenGivesItBack) {
  Powered bench;
  bench.drives.enable();
  bench.power.want_enabled(true, false);
  EXPECT_FALSE(bench.power.is_disabled(bench.state()));
  bench.power.want_enabled(false, false);
  const auto frames = bench.words();
  ASSERT_THAT(frames, SizeIs(1));
  EXPECT_TRUE(frames[0].drops_waiting) << "no set-point follows the end";
  EXPECT_THAT(words_of(frames, 1), ElementsAre(0x06));
  EXPECT_THAT(bench.words(), IsEmpty()) << "once a tick";
  (void)bench.drives.take(frames);
  bench.drives.step();
  EXPECT_THAT(bench.words(), IsEmpty());
  EXPECT_TRUE(bench.power.is_disabled(bench.state()));
  bench.drives.step();
  EXPECT_THAT(bench.words(), IsEmpty());
  EXPECT_THAT(bench.drives.control_wishes(),
              ElementsAre(ControlWish::take, ControlWish::leave, ControlWish::give_back));
}

// Words that are on their way act in a later tick than that of the latest state. An axis released
// before would be enabled without a master.
TEST(BenchPower, GivesNothingBackWhileWordsThatEnableAreOnTheirWay) {
  Powered bench;
  bench.power.want_enabled(true, false);
  ASSERT_THAT(bench.words(), SizeIs(3));
  bench.power.want_enabled(false, false);
  EXPECT_THAT(bench.words(1ms), IsEmpty());
  EXPECT_FALSE(bench.power.is_disabled(bench.state()));
  bench.drives.step();
  EXPECT_THAT(bench.words(2ms), IsEmpty()) << "this state may be older than the words, too";
  EXPECT_THAT(bench.drives.control_wishes(), ElementsAre(ControlWish::take, ControlWish::leave));
  bench.drives.enable();
  const auto frames = bench.words(3ms);
  EXPECT_THAT(words_of(frames, 1), ElementsAre(0x06));
  EXPECT_THAT(words_of(frames, 2), ElementsAre(0x06));
  (void)bench.drives.take(frames);
  bench.drives.step();
  EXPECT_THAT(bench.words(4ms), IsEmpty());
  EXPECT_TRUE(bench.power.is_disabled(bench.state()));
  EXPECT_THAT(bench.drives.control_wishes(),
              ElementsAre(ControlWish::take, ControlWish::leave, ControlWish::give_back));
}

TEST(BenchPower, GivesBackAfterHalfASecondWhatItsWordsDidNotEnable) {
  Powered bench;
  bench.power.want_enabled(true, false);
  ASSERT_THAT(bench.words(), SizeIs(3));
  bench.power.want_enabled(false, false);
  bench.power.want_enabled(false, false);  // two programs may request it
  bench.drives.step();
  EXPECT_THAT(bench.words(499ms), IsEmpty());
  EXPECT_FALSE(bench.power.is_disabled(bench.state()));
  EXPECT_THAT(bench.words(500ms), IsEmpty());
  EXPECT_TRUE(bench.power.is_disabled(bench.state()));
  EXPECT_THAT(bench.drives.control_wishes(),
              ElementsAre(ControlWish::take, ControlWish::leave, ControlWish::give_back));
}

TEST(BenchPower, ReportsEachFaultOnce) {
  Powered bench;
  bench.power.report_faults(bench.state());
  EXPECT_THAT(bench.written.lines, IsEmpty());
  bench.drives.show(1, PowerState::fault_reaction_active);
  bench.power.report_faults(bench.state());
  bench.drives.show(1, PowerState::fault);
  bench.power.report_faults(bench.state());
  EXPECT_THAT(bench.written.lines, ElementsAre(HasSubstr("joint y: shows")));
}

TEST(BenchPower, KeepsABenchInLockStepAliveEachTwentyMillisecondsOfDriveTime) {
  Powered bench;
  EXPECT_FALSE(bench.power.is_keep_alive_due(bench.state())) << "nothing is wanted";
  bench.power.want_enabled(true, false);
  EXPECT_TRUE(bench.power.is_keep_alive_due(bench.state()));
  for (int tick = 0; tick < 19; ++tick) bench.drives.step();
  EXPECT_FALSE(bench.power.is_keep_alive_due(bench.state()));
  bench.drives.step();
  EXPECT_TRUE(bench.power.is_keep_alive_due(bench.state()));
}

}  // namespace
}  // namespace vdrive::ros2
