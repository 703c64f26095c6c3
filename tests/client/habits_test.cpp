// SPDX-License-Identifier: Apache-2.0
// Client calls to drives with the habits of docs/guides/be-another-drive.md; the letters are those
// of its list.
#include "client/objects.hpp"
#include "support/bench_on_wire.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/client.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>
#include <utility>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::options_on_wire;
using testing::HasSubstr;
using testing::SizeIs;

/// Two axes in lock-step; the first has habits.
class DriveWithHabits : public testing::Test {
 protected:
  void have(std::string_view habit, std::int64_t value) {
    const auto written = axis_.write(vdrive::describe(*find_object(habit)).address, value);
    ASSERT_TRUE(written) << written.outcome().message();
  }

  [[nodiscard]] PowerState state() const { return axis_.status().value().state(); }

  void expect_move_to(std::int32_t target) {
    const Outcome moved = axis_.move_to(target);
    ASSERT_TRUE(moved) << moved.message();
    EXPECT_EQ(axis_.status().value().status.position_demand_value, target);
  }

  void expect_enabled() {
    const Outcome enabled = axis_.enable();
    ASSERT_TRUE(enabled) << enabled.message();
    ASSERT_EQ(state(), PowerState::operation_enabled);
  }

  void fail_axis() {
    ASSERT_TRUE(axis_.write(kOverCurrent, 1));
    ASSERT_TRUE(session_.step(1, 100));
    ASSERT_EQ(state(), PowerState::fault);
  }

 private:
  test::BenchOnWire bench_{"--clock lockstep --axes 2"};

 protected:
  Session session_{options_on_wire()};
  Axis axis_ = *session_.axis("1.1");
  Axis other_ = *session_.axis("1.2");
};

// a
TEST_F(DriveWithHabits, MovesWhereBit12IsUpAfterEnabling) {
  have("habit_acknowledge_at_enabling", 1);
  ASSERT_TRUE(axis_.write(kMode, 1));
  expect_enabled();
  EXPECT_TRUE(axis_.status().value().shows(Statusword::kSetPointAcknowledge));
  expect_move_to(1'000);
  expect_move_to(-500);
}

// b
TEST_F(DriveWithHabits, StreamsPositionsWithBits4To6WhereTheyAreNeeded) {
  have("habit_stream_release_bits", 1);
  auto group = AxisGroup::create(session_, std::array{axis_, other_}).value();
  ASSERT_TRUE(group.enable_all());
  ASSERT_TRUE(group.start_streaming());
  const auto shown = group.stream(Eigen::Vector2d(50.0, 50.0));
  ASSERT_TRUE(shown) << shown.outcome().message();
  EXPECT_THAT(shown->not_following(), SizeIs(0));
  EXPECT_EQ(shown->demand()[0], 50.0);
  EXPECT_EQ(shown->demand()[1], 50.0);
  EXPECT_EQ(axis_.read(kControlword).value(), 0x007F);
  EXPECT_EQ(other_.read(kControlword).value(), 0x000F) << "a drive without the habit";
  ASSERT_TRUE(group.halt_all());
  GroupCallOptions at_once;
  at_once.until = Until::in_force;
  ASSERT_TRUE(group.resume_all(at_once));
  EXPECT_EQ(axis_.read(kControlword).value(), 0x007F);
  ASSERT_TRUE(group.stop_streaming());
  EXPECT_EQ(axis_.read(kControlword).value(), 0x000F);
  expect_move_to(1'000);
}

// c, d
TEST_F(DriveWithHabits, StopsAndEnablesAgainWhateverQuickStopActiveDoes) {
  using Habit = std::pair<std::string_view, std::int64_t>;
  for (const auto& [habit, value] :
       {Habit{"habit_short_quick_stop", 1}, Habit{"habit_transition_16", 1},
        Habit{"habit_transition_16", 2}}) {
    SCOPED_TRACE(habit);
    have(habit, value);
    expect_enabled();
    expect_move_to(1'000);
    const Outcome stopped = axis_.quick_stop();
    EXPECT_TRUE(stopped) << stopped.message();
    EXPECT_EQ(state(), PowerState::switch_on_disabled);
    expect_enabled();
    expect_move_to(0);
    ASSERT_TRUE(axis_.disable());
    have(habit, 0);
  }
}

// d, with a 605Ah that keeps the drive in Quick stop active.
TEST_F(DriveWithHabits, EnablesFromQuickStopActiveWithoutTransition16) {
  have("habit_transition_16", 2);
  ASSERT_TRUE(axis_.write({0x605A, 0}, 6));
  expect_enabled();
  ASSERT_TRUE(axis_.quick_stop());
  ASSERT_EQ(state(), PowerState::quick_stop_active);
  expect_enabled();
}

// e
TEST_F(DriveWithHabits, AModeThatIsRefusedIsToldWithItsCode) {
  have("habit_mode_change_refusal", 2);
  expect_enabled();
  const Outcome refused = axis_.move_to(1'000);
  EXPECT_EQ(refused.kind(), OutcomeKind::refused) << refused.message();
  EXPECT_EQ(refused.code(), kRefusedInState);
  ASSERT_TRUE(axis_.disable());
  ASSERT_TRUE(axis_.write(kMode, 1));
  expect_enabled();
  expect_move_to(1'000);
}

// f
TEST_F(DriveWithHabits, MovesHomesAndStopsADriveThatLooksOnceIn4Ms) {
  have("habit_controlword_loop", 4);
  expect_enabled();
  for (const std::int32_t target : {1'000, 2'000, -300}) expect_move_to(target);
  // 2000 UU at 2000 UU/s take 1 s.
  const std::uint64_t before = axis_.status().value().tick;
  const std::int64_t usual = axis_.read(kVelocity).value();
  MoveOptions slowly;
  slowly.velocity = 2'000;
  const Outcome moved = axis_.move_to(1'700, slowly);
  ASSERT_TRUE(moved) << moved.message();
  EXPECT_GE(axis_.status().value().tick, before + 1'000);
  EXPECT_EQ(axis_.read(kVelocity).value(), usual);
  for (int run = 0; run < 2; ++run) {
    const Outcome homed = axis_.home({.method = 37, .offset = 100, .call = {}});
    ASSERT_TRUE(homed) << homed.message();
    EXPECT_TRUE(axis_.status().value().shows(Statusword::kHomingAttained));
  }
  const Outcome running = axis_.run_at(5'000);
  EXPECT_TRUE(running) << running.message();
  const Outcome halted = axis_.halt();
  EXPECT_TRUE(halted) << halted.message();
  ASSERT_NO_FATAL_FAILURE(fail_axis());
  ASSERT_TRUE(axis_.write(kOverCurrent, 0));
  const Outcome reset = axis_.reset_fault();
  ASSERT_TRUE(reset) << reset.message();
  EXPECT_EQ(state(), PowerState::switch_on_disabled);
  expect_enabled();
}

// f: the drive still shows its state from before the stop, which must not be taken for the state
// after it.
TEST_F(DriveWithHabits, AQuickStopOfADriveThatLooksSeldomEndsAtStandstill) {
  have("habit_controlword_loop", 16);
  auto group = AxisGroup::create(session_, std::array{axis_, other_}).value();
  for (const bool by_group : {false, true}) {
    SCOPED_TRACE(by_group);
    expect_enabled();
    const Outcome running = axis_.run_at(5'000);
    ASSERT_TRUE(running) << running.message();
    const Outcome stopped = by_group ? group.quick_stop_all() : axis_.quick_stop();
    EXPECT_TRUE(stopped) << stopped.message();
    EXPECT_EQ(state(), PowerState::switch_on_disabled);
    EXPECT_EQ(axis_.status().value().status.velocity_demand_value, 0);
  }
}

// f: in a group move this axis would start up to 4 ms after the others.
TEST_F(DriveWithHabits, AGroupMoveOfADriveThatLooksOnceIn4MsIsRefused) {
  have("habit_controlword_loop", 4);
  auto group = AxisGroup::create(session_, std::array{axis_, other_}).value();
  const Outcome enabled = group.enable_all();
  ASSERT_TRUE(enabled) << enabled.message();
  const Outcome refused = group.move_together(Eigen::Vector2d(1'000.0, 1'000.0));
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_THAT(refused.message(), HasSubstr("axis 1.1: habit_controlword_loop (5E20h:06) is 4"));
  ASSERT_TRUE(session_.step(1, 500));
  EXPECT_EQ(axis_.status().value().status.position_demand_value, 0);
  EXPECT_EQ(other_.status().value().status.position_demand_value, 0) << "no axis has started";
}

// k: where a new line starts in motion, this axis would lose its speed and leave the line.
TEST_F(DriveWithHabits, AGroupLineInMotionOfADriveThatPlansFromRestIsRefused) {
  have("habit_plan_from_rest", 1);
  auto group = AxisGroup::create(session_, std::array{axis_, other_}).value();
  ASSERT_TRUE(group.enable_all());
  GroupMoveOptions start;
  start.call.until = Until::in_force;
  ASSERT_TRUE(group.move_together(Eigen::Vector2d(100'000.0, 50'000.0), start));
  ASSERT_TRUE(session_.step(1, 100));
  const Outcome refused = group.move_together(Eigen::Vector2d(200'000.0, 100'000.0));
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_THAT(refused.message(), HasSubstr("axis 1.1: habit_plan_from_rest (5E20h:0B) is 1"));
  ASSERT_TRUE(group.wait_all()) << "the line in hand goes on";
  EXPECT_EQ(axis_.status().value().status.position_demand_value, 100'000);
}

// g
TEST_F(DriveWithHabits, EnablingWaitsForThePowerOfTheDrive) {
  have("habit_power_on_time", 300);
  ASSERT_TRUE(axis_.enable({.until = Until::in_force})) << "power is on its way";
  EXPECT_EQ(state(), PowerState::switched_on);
  expect_enabled();
  expect_move_to(1'000);
  ASSERT_TRUE(axis_.disable());
  const Outcome late = axis_.enable({.timeout = 100ms});
  EXPECT_EQ(late.kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.message(), HasSubstr("Switched on"));
}

TEST_F(DriveWithHabits, AGroupWaitsForThePowerOfItsSlowestDrive) {
  have("habit_power_on_time", 300);
  auto group = AxisGroup::create(session_, std::array{axis_, other_}).value();
  const Outcome enabled = group.enable_all();
  ASSERT_TRUE(enabled) << enabled.message();
  const Outcome moved = group.move_together(Eigen::Vector2d(1'000.0, 500.0));
  EXPECT_TRUE(moved) << moved.message();
}

// h
TEST_F(DriveWithHabits, WaitsForTheModeThatIsShownLate) {
  have("habit_mode_display_delay", 100);
  expect_enabled();
  expect_move_to(1'000);
  const Outcome homed = axis_.home({.method = 37, .call = {}});
  EXPECT_TRUE(homed) << homed.message();
  const Outcome running = axis_.run_at(1'000);
  EXPECT_TRUE(running) << running.message();
}

TEST_F(DriveWithHabits, AGroupMoveWaitsForTheModeThatIsShownLate) {
  have("habit_mode_display_delay", 100);
  auto group = AxisGroup::create(session_, std::array{axis_, other_}).value();
  ASSERT_TRUE(group.enable_all());
  ASSERT_EQ(axis_.status().value().mode(), OperatingMode::none);
  const Outcome moved = group.move_together(Eigen::Vector2d(1'000.0, -500.0));
  EXPECT_TRUE(moved) << moved.message();
  EXPECT_EQ(axis_.status().value().status.position_demand_value, 1'000);
  EXPECT_EQ(other_.status().value().status.position_demand_value, -500);
}

// i
TEST_F(DriveWithHabits, AResetWaitsForItsEffect) {
  have("habit_fault_reset_delay", 30);
  ASSERT_NO_FATAL_FAILURE(fail_axis());
  ASSERT_TRUE(axis_.write(kOverCurrent, 0));
  const Outcome reset = axis_.reset_fault();
  ASSERT_TRUE(reset) << reset.message();
  expect_enabled();
  ASSERT_NO_FATAL_FAILURE(fail_axis());
  ASSERT_TRUE(axis_.write(kOverCurrent, 0));
  auto group = AxisGroup::create(session_, std::array{axis_, other_}).value();
  const Outcome all = group.reset_all();
  EXPECT_TRUE(all) << all.message();
  EXPECT_EQ(state(), PowerState::switch_on_disabled);
}

// j: in cyclic position mode bit 10 has no meaning for a stream.
TEST_F(DriveWithHabits, StreamsWhereBit10Toggles) {
  have("habit_stream_target_bit", 1);
  auto group = AxisGroup::create(session_, std::array{axis_}).value();
  ASSERT_TRUE(group.enable_all());
  ASSERT_TRUE(group.start_streaming());
  for (int tick = 1; tick <= 20; ++tick) {
    const auto shown = group.stream(Eigen::VectorXd::Constant(1, 10.0 * tick));
    ASSERT_TRUE(shown) << shown.outcome().message();
    ASSERT_THAT(shown->not_following(), SizeIs(0));
  }
  const Outcome stopped = group.stop_streaming();
  EXPECT_TRUE(stopped) << stopped.message();
}

// k, l, m, n
TEST_F(DriveWithHabits, MovesHomesAndRunsWithTheOthers) {
  have("habit_plan_from_rest", 1);
  have("habit_statusword_bits", 0xC200);
  have("habit_homing_by_level", 1);
  have("habit_clear_target_velocity", 1);
  expect_enabled();
  expect_move_to(1'000);
  const Outcome homed = axis_.home({.method = 37, .call = {}});
  EXPECT_TRUE(homed) << homed.message();
  const Outcome running = axis_.run_at(1'000);
  EXPECT_TRUE(running) << running.message();
  EXPECT_TRUE(axis_.run_at(0));
}

// p
TEST_F(DriveWithHabits, EnablingWaitsInSwitchedOnUntilAModeIsChosen) {
  have("habit_mode_before_enabling", 1);
  const Outcome refused = axis_.enable({.timeout = 100ms});
  EXPECT_EQ(refused.kind(), OutcomeKind::timed_out);
  EXPECT_THAT(refused.message(), HasSubstr("Switched on"));
  ASSERT_TRUE(axis_.write(kMode, 1));
  expect_enabled();
  expect_move_to(1'000);
}

}  // namespace
}  // namespace vdrive::client
