// SPDX-License-Identifier: Apache-2.0
// Habits of other drives, 5E20h: each against the same drive without it.
// docs/guides/be-another-drive.md lists where they were seen.
#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/cia402/power_state_machine.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

constexpr std::array<std::string_view, 16> kHabits{
    "habit_acknowledge_at_enabling", "habit_stream_release_bits",   "habit_short_quick_stop",
    "habit_transition_16",           "habit_mode_change_refusal",   "habit_controlword_loop",
    "habit_power_on_time",           "habit_mode_display_delay",    "habit_fault_reset_delay",
    "habit_stream_target_bit",       "habit_plan_from_rest",        "habit_statusword_bits",
    "habit_homing_by_level",         "habit_clear_target_velocity", "habit_homing_ends_at_halt",
    "habit_mode_before_enabling"};

template <std::size_t kCount>
using Words = std::array<std::uint16_t, kCount>;

bool shows_bit(const AxisUnderTest& axis, unsigned bit) {
  return (axis.statusword() >> bit & 1U) != 0;
}

/// At 10000 UU/s on a long move, controlword 001Fh, with following error monitoring off.
void run_far(AxisUnderTest& axis) {
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.write("profile_velocity", 10'000);
  axis.write("profile_acc", 1'000'000);
  axis.enable();
  axis.write("position_user_target_value", 1'000'000);
  axis.command(0x001F);
  axis.step(200);
  ASSERT_EQ(axis.demand_velocity(), 10'000);
}

/// Cyclic position, Operation enabled.
void enable_stream(AxisUnderTest& axis) {
  axis.write("op_mode_cmd", 8);
  axis.command(0x000F);
}

/// In Fault, from an over-current that persists.
void fail(AxisUnderTest& axis) {
  axis.write("test_over_current", 1);
  axis.step(100);
  ASSERT_EQ(axis.state(), fault);
}

// ---- all habits --------------------------------------------------------------------------------

TEST(Habits, AreOffByDefaultAndHaveARowEach) {
  const AxisUnderTest axis;
  for (std::size_t i = 0; i < kHabits.size(); ++i) {
    const ObjectAddress address = AxisUnderTest::address_of(kHabits[i]);
    EXPECT_EQ(address, (ObjectAddress{0x5E20, static_cast<std::uint8_t>(i + 1)})) << kHabits[i];
    EXPECT_EQ(axis.read(kHabits[i]), 0) << kHabits[i];
  }
}

TEST(Habits, RefuseOtherValuesAndAreNotStored) {
  AxisUnderTest axis;
  for (const std::string_view habit : kHabits) {
    const ObjectDescription& object = describe(*find_object(habit));
    EXPECT_EQ(axis.try_write(habit, object.upper_limit), AbortCode::none) << habit;
    EXPECT_EQ(axis.try_write(habit, object.upper_limit + 1), AbortCode::value_too_high) << habit;
    EXPECT_EQ(axis.try_write(habit, -1), AbortCode::value_too_low) << habit;
    EXPECT_EQ(axis.axis().set_stored(object.address, 0), AbortCode::cannot_store_or_transfer)
        << habit;
  }
}

/// Enables, moves, halts, stops, fails, resets and homes; a bank of one axis.
class Program {
 public:
  explicit Program(bool toggles)
      : bank_(std::vector<AxisConfiguration>(1), std::chrono::milliseconds{1}) {
    for (const std::string_view habit : kHabits) {
      if (!toggles) break;
      put(habit, describe(*find_object(habit)).upper_limit);
      put(habit, 0);
    }
  }

  void run(std::vector<std::uint64_t>& hashes) {
    put("op_mode_cmd", 1);
    for (const std::int64_t word : {0x06, 0x07, 0x0F}) pass(word, 1, hashes);
    put("position_user_target_value", 20'000);
    for (const std::int64_t word : {0x1F, 0x10F, 0x0F, 0x02, 0x0F}) pass(word, 100, hashes);
    put("test_over_current", 1);
    pass(0x0F, 100, hashes);
    put("test_over_current", 0);
    for (const std::int64_t word : {0x80, 0x00, 0x0F}) pass(word, 5, hashes);
    put("op_mode_cmd", 8);
    put("position_user_target_value", 100);
    pass(0x0F, 5, hashes);
    put("op_mode_cmd", 6);
    for (const std::int64_t word : {0x1F, 0x0F}) pass(word, 50, hashes);
  }

 private:
  void put(std::string_view name, std::int64_t value) {
    EXPECT_EQ(bank_.write(0, AxisUnderTest::address_of(name), value), AbortCode::none) << name;
  }

  void pass(std::int64_t word, int ticks, std::vector<std::uint64_t>& hashes) {
    put("ds402_controlword", word);
    for (int tick = 0; tick < ticks; ++tick) {
      bank_.step();
      hashes.push_back(bank_.status_hash());
    }
  }

  AxisBank bank_;
};

TEST(Habits, SwitchedOffAgainLeaveNoBitBehind) {
  std::vector<std::uint64_t> untouched;
  std::vector<std::uint64_t> toggled;
  Program(false).run(untouched);
  Program(true).run(toggled);
  EXPECT_EQ(untouched, toggled);
}

TEST(Habits, OutlastAPowerCycleWhileWhatTheyHeldBackDoesNot) {
  AxisConfiguration configuration;
  configuration.parameters = {{AxisUnderTest::address_of("habit_power_on_time"), 50}};
  AxisUnderTest axis(configuration);
  EXPECT_EQ(axis.read("habit_power_on_time"), 50);
  axis.command(0x000F);
  ASSERT_EQ(axis.state(), switched_on);
  axis.axis().power_cycle();
  axis.step(200);
  EXPECT_EQ(axis.state(), switch_on_disabled);
  EXPECT_EQ(axis.read("habit_power_on_time"), 50);
  axis.command(0x000F);
  EXPECT_EQ(axis.state(), switched_on);
}

TEST(Habits, AndWhatTheyHoldBackArePartOfASnapshot) {
  AxisBank bank(std::vector<AxisConfiguration>(1), std::chrono::milliseconds{1});
  const auto put = [&bank](std::string_view name, std::int64_t value) {
    EXPECT_EQ(bank.write(0, AxisUnderTest::address_of(name), value), AbortCode::none) << name;
  };
  put("habit_controlword_loop", 3);
  put("habit_power_on_time", 20);
  put("habit_mode_display_delay", 30);
  put("op_mode_cmd", 1);
  put("ds402_controlword", 0x000F);
  for (int tick = 0; tick < 10; ++tick) bank.step();
  put("ds402_controlword", 0x010F);
  const AxisBank::Snapshot saved = bank.snapshot_from(bank.snapshot().bytes());
  const auto run = [&bank] {
    std::vector<std::uint64_t> hashes;
    for (int tick = 0; tick < 50; ++tick) {
      bank.step();
      hashes.push_back(bank.status_hash());
    }
    return hashes;
  };
  const std::vector<std::uint64_t> first = run();
  EXPECT_EQ(bank.power_state(0), operation_enabled);
  EXPECT_EQ(bank.status(0).op_mode_actual, 1);
  bank.restore(saved);
  EXPECT_EQ(bank.power_state(0), switched_on);
  EXPECT_EQ(run(), first);
}

// ---- a: bit 12 is set right after enabling -----------------------------------------------------

TEST(HabitAcknowledgeAtEnabling, ShowsBit12UntilTheFirstSetPointHasPassed) {
  AxisUnderTest axis;
  axis.write("habit_acknowledge_at_enabling", 1);
  axis.enable();
  EXPECT_TRUE(axis.acknowledged());
  axis.command(0x000F);
  axis.step(50);
  EXPECT_TRUE(axis.acknowledged()) << "no set-point was written yet";
  axis.write("position_user_target_value", 100);
  axis.command(0x003F);
  EXPECT_TRUE(axis.acknowledged()) << "as by the standard";
  axis.command(0x000F);
  EXPECT_FALSE(axis.acknowledged()) << "bit 4 was 1 and is 0 again";
  axis.step(200);
  EXPECT_EQ(axis.demand(), 100);
  axis.command(0x0006);
  axis.command(0x000F);
  EXPECT_TRUE(axis.acknowledged()) << "enabled again";
}

TEST(HabitAcknowledgeAtEnabling, IsOfProfilePositionOnly) {
  AxisUnderTest axis;
  axis.write("habit_acknowledge_at_enabling", 1);
  enable_stream(axis);
  EXPECT_FALSE(shows_bit(axis, 12));
  axis.write("op_mode_cmd", 1);
  axis.step(5);
  EXPECT_FALSE(axis.acknowledged()) << "the mode came after enabling";
}

// ---- b: cyclic position needs bits 4 to 6 -------------------------------------------------------

TEST(HabitStreamReleaseBits, HoldTheAxisUntilAllThreeAreSet) {
  AxisUnderTest axis;
  axis.write("habit_stream_release_bits", 1);
  enable_stream(axis);
  axis.write("position_user_target_value", 100);
  for (const std::uint16_t word : Words<4>{0x000F, 0x001F, 0x003F, 0x006F}) {
    axis.command(word);
    EXPECT_EQ(axis.demand(), 0) << word;
    EXPECT_FALSE(shows_bit(axis, 12)) << word;
  }
  axis.command(0x007F);
  EXPECT_EQ(axis.demand(), 100);
  EXPECT_TRUE(shows_bit(axis, 12));
  EXPECT_EQ(axis.status().ignored_set_points, 0U) << "bit 4 is no set-point here";
  axis.step(2);
  axis.command(0x003F);
  axis.write("position_user_target_value", 50);
  axis.step(20);
  EXPECT_EQ(axis.demand(), 100);
  EXPECT_FALSE(shows_bit(axis, 12));
}

// 60C2h = 10 ms: 10 UU per tick once the stream is released.
TEST(HabitStreamReleaseBits, TheWayBeginsWithTheRelease) {
  AxisUnderTest axis;
  axis.write("habit_stream_release_bits", 1);
  axis.write("interpolation_time_period", 10);
  enable_stream(axis);
  axis.write("position_user_target_value", 100);
  axis.step(30);
  EXPECT_EQ(axis.demand(), 0);
  axis.command(0x007F);
  EXPECT_EQ(axis.demand(), 10);
  axis.step(9);
  EXPECT_EQ(axis.demand(), 100);
}

// ---- c: quick stop active lasts one sample ------------------------------------------------------

TEST(HabitShortQuickStop, EndsWithTheNextTickWhateverStillMoves) {
  AxisUnderTest axis;
  axis.write("habit_short_quick_stop", 1);
  run_far(axis);
  axis.command(0x0002);
  EXPECT_EQ(axis.state(), quick_stop_active);
  axis.step();
  EXPECT_EQ(axis.statusword(), 0x0250);
  EXPECT_EQ(axis.status().motor_op_status, 0);
  EXPECT_GT(axis.velocity(), 5'000) << "it coasts";

  // By the standard, braking from 10000 UU/s with 6085h = 2048000 UU/s² takes 5 ms.
  AxisUnderTest usual;
  run_far(usual);
  usual.command(0x0002);
  usual.step(2);
  EXPECT_EQ(usual.state(), quick_stop_active);
}

TEST(HabitShortQuickStop, LeavesTheStateWhere605AhKeepsIt) {
  AxisUnderTest axis;
  axis.write("habit_short_quick_stop", 1);
  axis.write("quick_stop_option_code", 6);
  run_far(axis);
  axis.command(0x0002);
  axis.step(100);
  EXPECT_EQ(axis.state(), quick_stop_active);
  EXPECT_EQ(axis.demand_velocity(), 0);
}

// ---- d: transition 16 ---------------------------------------------------------------------------

struct Transition16Case {
  std::int64_t habit;
  std::int64_t option;  // 605Ah
  PowerState state;     // after 000Fh in Quick stop active
};

TEST(HabitTransition16, DecidesWhetherEnableOperationLeavesQuickStopActive) {
  for (const auto& [habit, option, state] :
       {Transition16Case{0, 2, quick_stop_active}, Transition16Case{0, 6, operation_enabled},
        Transition16Case{1, 2, operation_enabled}, Transition16Case{1, 6, operation_enabled},
        Transition16Case{2, 2, quick_stop_active}, Transition16Case{2, 6, quick_stop_active}}) {
    SCOPED_TRACE(std::to_string(habit) + " with 605Ah = " + std::to_string(option));
    AxisUnderTest axis;
    axis.write("habit_transition_16", habit);
    axis.write("quick_stop_option_code", option);
    ASSERT_NO_FATAL_FAILURE(run_far(axis));
    axis.command(0x0002);
    ASSERT_EQ(axis.state(), quick_stop_active);
    axis.command(0x000F);
    EXPECT_EQ(axis.state(), state);
    axis.step(500);
    EXPECT_EQ(axis.demand_velocity(), 0) << "the interrupted move is forgotten";
  }
}

TEST(HabitTransition16, IsAnOptionOfThePowerStateMachine) {
  for (const Transition16 habit : {Transition16::always, Transition16::never}) {
    const PowerOptions options{.transition_16 = habit};
    PowerStateMachine machine;
    machine.initialised();
    machine.command(PowerCommand::enable_operation, options, true, false);
    machine.command(PowerCommand::quick_stop, options, true, false);
    ASSERT_EQ(machine.state(), quick_stop_active);
    const auto taken = machine.command(PowerCommand::enable_operation, options, true, false);
    EXPECT_EQ(taken.contains(16), habit == Transition16::always);
  }
}

// ---- e: mode changes are refused ---------------------------------------------------------------

TEST(HabitModeChangeRefusal, RefusesAnotherModeUnderHalt) {
  AxisUnderTest axis;
  axis.write("habit_mode_change_refusal", 1);
  axis.enable();
  axis.command(0x010F);
  EXPECT_EQ(axis.try_write("op_mode_cmd", 3), AbortCode::refused_in_present_device_state);
  EXPECT_EQ(axis.read("op_mode_cmd"), 1);
  EXPECT_EQ(axis.try_write("op_mode_cmd", 1), AbortCode::none) << "no change";
  axis.step(20);
  EXPECT_EQ(axis.status().op_mode_actual, 1);
  axis.command(0x000F);
  EXPECT_EQ(axis.try_write("op_mode_cmd", 3), AbortCode::none);
  axis.step();
  EXPECT_EQ(axis.status().op_mode_actual, 3);
}

TEST(HabitModeChangeRefusal, RefusesAnotherModeAboveSwitchedOn) {
  AxisUnderTest axis;
  axis.write("habit_mode_change_refusal", 2);
  for (const std::uint16_t word : Words<3>{0x0000, 0x0006, 0x0007}) {
    axis.command(word);
    EXPECT_EQ(axis.try_write("op_mode_cmd", word == 0x0006 ? 3 : 1), AbortCode::none) << word;
  }
  axis.command(0x000F);
  ASSERT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.try_write("op_mode_cmd", 3), AbortCode::refused_in_present_device_state);
  axis.write("quick_stop_option_code", 6);
  axis.command(0x0002);
  EXPECT_EQ(axis.try_write("op_mode_cmd", 3), AbortCode::refused_in_present_device_state);
  ASSERT_NO_FATAL_FAILURE(fail(axis));
  EXPECT_EQ(axis.try_write("op_mode_cmd", 3), AbortCode::refused_in_present_device_state);
  EXPECT_EQ(axis.try_write("op_mode_cmd", 2'000), AbortCode::value_too_high) << "as ever";
}

TEST(HabitModeChangeRefusal, RefusesAnotherModeInBothCasesWith3) {
  AxisUnderTest axis;
  axis.write("habit_mode_change_refusal", 3);
  axis.command(0x0006);
  axis.command(0x0107);
  ASSERT_EQ(axis.state(), switched_on);
  EXPECT_EQ(axis.try_write("op_mode_cmd", 3), AbortCode::refused_in_present_device_state);
  axis.command(0x0007);
  EXPECT_EQ(axis.try_write("op_mode_cmd", 3), AbortCode::none);
  axis.command(0x000F);
  ASSERT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.try_write("op_mode_cmd", 1), AbortCode::refused_in_present_device_state);
}

// ---- f: controlwords are sampled once per loop -------------------------------------------------

TEST(HabitControlwordLoop, TakesTheLastWordOfTheLoop) {
  AxisUnderTest axis;
  axis.write("habit_controlword_loop", 4);
  axis.controlword(0x0006);
  EXPECT_EQ(axis.read("ds402_controlword"), 0x0006) << "it reads back at once";
  axis.step(3);
  EXPECT_EQ(axis.state(), switch_on_disabled);
  axis.step();
  EXPECT_EQ(axis.state(), ready_to_switch_on) << "the 4th tick of the loop";
  axis.command(0x0000);
  axis.command(0x0007);
  axis.step();
  EXPECT_EQ(axis.state(), ready_to_switch_on);
  axis.step();
  EXPECT_EQ(axis.state(), switched_on) << "nobody has seen 0000h";
}

TEST(HabitControlwordLoop, CountsAnEdgeThatNoLookShows) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("habit_controlword_loop", 4);
  axis.write("position_user_target_value", 1'000);
  axis.command(0x003F);
  axis.command(0x000F);
  axis.step(500);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_FALSE(axis.acknowledged());
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
}

TEST(HabitControlwordLoop, TakesAnEdgeThatLastsALoop) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("habit_controlword_loop", 4);
  axis.write("position_user_target_value", 1'000);
  axis.controlword(0x003F);
  axis.step(4);
  EXPECT_TRUE(axis.acknowledged());
  // Clearing and setting bit 4 again between two samples is not a second edge.
  axis.write("position_user_target_value", 5'000);
  axis.command(0x000F);
  axis.command(0x003F);
  axis.step(500);
  EXPECT_EQ(axis.demand(), 1'000);
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
}

TEST(HabitControlwordLoop, LosesNoWordWhenItIsSwitchedOff) {
  AxisUnderTest axis;
  axis.write("habit_controlword_loop", 1'000);
  axis.command(0x0006);
  EXPECT_EQ(axis.state(), switch_on_disabled);
  axis.write("habit_controlword_loop", 0);
  axis.step();
  EXPECT_EQ(axis.state(), ready_to_switch_on);
  axis.write("habit_controlword_loop", 1'000);
  axis.command(0x000F);
  axis.write("habit_controlword_loop", 0);
  axis.command(0x0007);
  EXPECT_EQ(axis.state(), operation_enabled) << "enabled, and 605Ch has 0007h ramp to Switched on";
  axis.step();
  EXPECT_EQ(axis.state(), switched_on) << "the words kept their order";
}

// ---- g: power on is delayed --------------------------------------------------------------------

TEST(HabitPowerOnTime, ShowsSwitchedOnUntilPowerIsOn) {
  AxisUnderTest axis;
  axis.write("habit_power_on_time", 200);
  axis.enable();  // tick 1 of 200
  EXPECT_EQ(axis.statusword(), 0x0233);
  axis.step(199);
  EXPECT_EQ(axis.statusword(), 0x0233);
  EXPECT_EQ(axis.status().motor_op_status, 0);
  axis.step();
  EXPECT_EQ(axis.statusword(), 0x0637);
}

TEST(HabitPowerOnTime, CountsFromTheFirstEnableOperation) {
  AxisUnderTest axis;
  axis.write("habit_power_on_time", 50);
  for (const std::uint16_t word : Words<2>{0x0006, 0x0007}) axis.command(word);
  axis.step(100);
  EXPECT_EQ(axis.state(), switched_on) << "Switch on alone begins nothing";
  for (int tick = 0; tick < 50; ++tick) axis.command(0x000F);
  EXPECT_EQ(axis.state(), switched_on);
  axis.command(0x000F);
  EXPECT_EQ(axis.state(), operation_enabled);
}

TEST(HabitPowerOnTime, IsTakenBackByAnotherCommandAndByAFault) {
  for (const std::uint16_t word : Words<4>{0x0007, 0x0006, 0x0002, 0x0000}) {
    AxisUnderTest axis;
    axis.write("habit_power_on_time", 50);
    axis.command(0x000F);
    axis.command(word);
    axis.step(200);
    EXPECT_NE(axis.state(), operation_enabled) << word;
  }
  AxisUnderTest axis;
  axis.write("habit_power_on_time", 50);
  axis.command(0x000F);
  axis.write("test_over_current", 1);
  axis.step(200);
  EXPECT_EQ(axis.state(), fault);
  AxisUnderTest dark;
  dark.write("habit_power_on_time", 50);
  dark.command(0x000F);
  dark.write("test_dc_link_loss", 1);
  dark.step(200);
  EXPECT_EQ(dark.state(), switch_on_disabled);
}

TEST(HabitPowerOnTime, IsTakenBackWithTheMaster) {
  for (const std::int64_t option : {0, 1, 2, 3}) {
    AxisUnderTest axis;
    axis.write("abort_connection_option_code", option);
    axis.write("habit_power_on_time", 50);
    axis.command(0x000F);
    axis.axis().report_connection_loss();
    axis.step(200);
    EXPECT_EQ(axis.state(), option == 0 ? operation_enabled : switched_on) << option;
  }
}

TEST(HabitPowerOnTime, TakesNoSetPointUntilPowerIsOn) {
  AxisUnderTest axis;
  axis.write("habit_power_on_time", 20);
  axis.write("position_user_target_value", 1'000);
  axis.enable();
  axis.command(0x003F);
  axis.step(500);
  EXPECT_EQ(axis.state(), operation_enabled);
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_EQ(axis.status().ignored_set_points, 1U);
}

// ---- h: 6061h is delayed -----------------------------------------------------------------------

TEST(HabitModeDisplayDelay, ShowsAndHasTheOldModeUntilTheDelayEnds) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("habit_mode_display_delay", 20);
  axis.write("op_mode_cmd", 3);
  axis.write("target_velocity", 1'000);
  axis.step(20);
  EXPECT_EQ(axis.status().op_mode_actual, 1);
  EXPECT_EQ(axis.demand_velocity(), 0);
  axis.step();
  EXPECT_EQ(axis.status().op_mode_actual, 3);
  axis.step(50);
  EXPECT_EQ(axis.demand_velocity(), 1'000);
}

TEST(HabitModeDisplayDelay, IsTakenBackWithTheMode) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("habit_mode_display_delay", 20);
  axis.write("op_mode_cmd", 3);
  axis.step(5);
  axis.write("op_mode_cmd", 1);
  axis.step();
  axis.write("op_mode_cmd", 3);
  axis.step(20);
  EXPECT_EQ(axis.status().op_mode_actual, 1) << "counted anew";
  axis.step();
  EXPECT_EQ(axis.status().op_mode_actual, 3);
}

// ---- i: the fault reset is delayed -------------------------------------------------------------

TEST(HabitFaultResetDelay, EndsTheFaultLater) {
  AxisUnderTest axis;
  axis.write("habit_fault_reset_delay", 30);
  ASSERT_NO_FATAL_FAILURE(fail(axis));
  axis.write("test_over_current", 0);
  axis.command(0x0080);
  axis.command(0x0000);
  axis.step(28);
  EXPECT_EQ(axis.state(), fault);
  axis.step();
  EXPECT_EQ(axis.statusword(), 0x0250);
  EXPECT_EQ(axis.read("error_code"), 0);
}

TEST(HabitFaultResetDelay, ACauseThatPersistsIsAFaultAgainAtOnce) {
  AxisUnderTest axis;
  axis.write("habit_fault_reset_delay", 10);
  ASSERT_NO_FATAL_FAILURE(fail(axis));
  axis.command(0x0080);
  axis.step(9);
  EXPECT_EQ(axis.state(), fault);
  axis.step();
  EXPECT_EQ(axis.state(), switch_on_disabled) << "what a hasty master takes for success";
  axis.step();
  EXPECT_EQ(axis.state(), fault_reaction_active);
  axis.step(5);
  EXPECT_EQ(axis.state(), fault);
  EXPECT_EQ(axis.status().fault_count, 2U);
  EXPECT_EQ(axis.read("error_code"), 0x2310);
}

// ---- j: bit 10 between streamed points ----------------------------------------------------------

TEST(HabitStreamTargetBit, TogglesFromPointToPoint) {
  AxisUnderTest axis;
  axis.write("habit_stream_target_bit", 1);
  enable_stream(axis);
  for (const std::int32_t point : {100, 200, 150}) {
    axis.write("position_user_target_value", point);
    axis.step();
    EXPECT_FALSE(axis.reached()) << point;
    EXPECT_TRUE(shows_bit(axis, 12)) << point;
    axis.step();
    EXPECT_TRUE(axis.reached()) << point;
  }
  AxisUnderTest usual;
  enable_stream(usual);
  usual.write("position_user_target_value", 100);
  usual.step(10);
  EXPECT_FALSE(usual.reached()) << "bit 10 is reserved in this mode";
}

// ---- k: a new plan starts from standstill -------------------------------------------------------

TEST(HabitPlanFromRest, PlansAMoveUnderWayFromVelocity0) {
  AxisUnderTest axis;
  axis.write("habit_plan_from_rest", 1);
  ASSERT_NO_FATAL_FAILURE(run_far(axis));
  const std::int32_t before = axis.demand();
  axis.write("profile_acc", 200'000);
  axis.step();
  EXPECT_EQ(axis.demand_velocity(), 200) << "200000 UU/s² for 1 ms";
  EXPECT_GE(axis.demand(), before) << "the position makes no step";
  EXPECT_LE(axis.demand(), before + 1);
  axis.step(500);
  EXPECT_EQ(axis.demand_velocity(), 10'000);
  axis.write("position_user_target_value", 2'000'000);
  axis.command(0x000F);
  axis.command(0x003F);
  EXPECT_EQ(axis.demand_velocity(), 200) << "a set-point, too";
}

TEST(HabitPlanFromRest, LeavesStopsAsTheyAre) {
  AxisUnderTest axis;
  axis.write("habit_plan_from_rest", 1);
  ASSERT_NO_FATAL_FAILURE(run_far(axis));
  axis.command(0x010F);
  EXPECT_EQ(axis.demand_velocity(), 9'590) << "10000 UU/s less 409600 UU/s² for 1 ms";
}

// ---- l: manufacturer-specific bits -------------------------------------------------------------

TEST(HabitStatuswordBits, AreShownTheOtherWayRoundInEachState) {
  AxisUnderTest axis;
  axis.write("habit_statusword_bits", 0xC200);
  EXPECT_EQ(axis.step(), 0xC050);
  EXPECT_EQ(axis.command(0x0006), 0xC031);
  axis.enable();
  EXPECT_EQ(axis.statusword(), 0xC437);
  axis.step(50);
  axis.write("habit_statusword_bits", 0x4000);
  EXPECT_EQ(axis.step(), 0x4637);
  axis.axis().power_cycle();
  EXPECT_EQ(axis.statusword(), 0x4200) << "not ready to switch on";
}

TEST(HabitStatuswordBits, RefusesBitsThatTheStandardHas) {
  AxisUnderTest axis;
  for (const std::int64_t value : {0x0001, 0x0400, 0x1000, 0x4001}) {
    EXPECT_EQ(axis.try_write("habit_statusword_bits", value), AbortCode::value_range_exceeded)
        << value;
  }
  EXPECT_EQ(axis.read("habit_statusword_bits"), 0);
}

// ---- m: bit 4 of homing is a level --------------------------------------------------------------

/// Starts a homing run with this value of a habit.
void home_with(AxisUnderTest& axis, std::string_view habit, std::int64_t value,
               std::int64_t method) {
  axis.write(habit, value);
  axis.write("homing_method", method);
  axis.write("op_mode_cmd", 6);
  axis.command(0x000F);
  axis.command(0x001F);
}

TEST(HabitHomingByLevel, DroppingBit4EndsTheRun) {
  for (const std::int64_t habit : {0, 1}) {
    SCOPED_TRACE(habit);
    AxisUnderTest axis;
    home_with(axis, "habit_homing_by_level", habit, 17);
    axis.step(50);
    ASSERT_LT(axis.demand_velocity(), -10'000) << "towards the negative switch";
    axis.command(0x000F);
    axis.step(200);
    EXPECT_EQ(axis.demand_velocity(), habit == 0 ? -34'133 : 0);
    EXPECT_EQ(axis.statusword() & 0x3400, habit == 0 ? 0x0000 : 0x0400) << "under way, or idle";
  }
}

TEST(HabitHomingByLevel, KeepsTheResultOfARunThatHasEnded) {
  AxisUnderTest axis;
  home_with(axis, "habit_homing_by_level", 1, 37);
  axis.step(100);
  ASSERT_EQ(axis.statusword() & 0x3400, 0x1400);
  axis.command(0x000F);
  EXPECT_EQ(axis.statusword() & 0x3400, 0x1400);
}

// ---- o: halt ends a homing run ------------------------------------------------------------------

TEST(HabitHomingEndsAtHalt, LeavesNoRunThatContinues) {
  for (const std::int64_t habit : {0, 1}) {
    SCOPED_TRACE(habit);
    AxisUnderTest axis;
    home_with(axis, "habit_homing_ends_at_halt", habit, 17);
    axis.step(50);
    axis.command(0x011F);
    axis.step(500);
    EXPECT_EQ(axis.statusword() & 0x3400, 0x0400) << "it stands";
    axis.command(0x001F);
    axis.step(200);
    EXPECT_EQ(axis.demand_velocity(), habit == 0 ? -34'133 : 0);
    EXPECT_EQ(axis.statusword() & 0x3400, habit == 0 ? 0x0000 : 0x0400) << "under way, or idle";
  }
}

// ---- p: no enabling without a mode --------------------------------------------------------------

TEST(HabitModeBeforeEnabling, StaysInSwitchedOnWhile6060hIs0) {
  for (const std::int64_t habit : {0, 1}) {
    SCOPED_TRACE(habit);
    AxisUnderTest axis;
    axis.write("habit_mode_before_enabling", habit);
    axis.command(0x000F);
    axis.step(100);
    EXPECT_EQ(axis.state(), habit == 0 ? operation_enabled : switched_on);
    EXPECT_EQ(axis.status().motor_op_status, habit == 0 ? 1 : 0);
    EXPECT_EQ(axis.read("error_code"), 0);
  }
}

TEST(HabitModeBeforeEnabling, RefusesTransition4AloneOfThoseOnTheWay) {
  AxisUnderTest axis;
  axis.write("habit_mode_before_enabling", 1);
  axis.command(0x0006);
  EXPECT_EQ(axis.state(), ready_to_switch_on);
  axis.command(0x000F);
  EXPECT_EQ(axis.state(), switched_on) << "transition 3";
  axis.command(0x000F);
  EXPECT_EQ(axis.state(), switched_on);
  axis.command(0x0006);
  EXPECT_EQ(axis.state(), ready_to_switch_on) << "other commands are ordinary ones";
}

TEST(HabitModeBeforeEnabling, EnablesWithTheNextControlwordAfterTheMode) {
  AxisUnderTest axis;
  axis.write("habit_mode_before_enabling", 1);
  axis.command(0x000F);
  axis.write("op_mode_cmd", 3);
  axis.step(100);
  EXPECT_EQ(axis.state(), switched_on) << "a mode is no command";
  axis.command(0x000F);
  EXPECT_EQ(axis.state(), operation_enabled);
}

TEST(HabitModeBeforeEnabling, TakesAModeThatComesBeforeTheControlwordInTheSameTick) {
  AxisUnderTest axis;
  axis.write("habit_mode_before_enabling", 1);
  axis.write("op_mode_cmd", 8);
  axis.command(0x000F);
  EXPECT_EQ(axis.state(), operation_enabled);
}

TEST(HabitModeBeforeEnabling, LeavesAnEnabledAxisEnabled) {
  AxisUnderTest axis;
  axis.write("habit_mode_before_enabling", 1);
  axis.enable();
  axis.write("op_mode_cmd", 0);
  axis.command(0x000F);
  EXPECT_EQ(axis.state(), operation_enabled);
  axis.step(100);
  EXPECT_EQ(axis.state(), operation_enabled);
}

// 605Ah = 6: the axis has had a mode since transition 4, and keeps its power.
TEST(HabitModeBeforeEnabling, LeavesTransition16AsItIs) {
  AxisUnderTest axis;
  axis.write("habit_mode_before_enabling", 1);
  axis.write("quick_stop_option_code", 6);
  axis.enable();
  axis.command(0x0002);
  axis.write("op_mode_cmd", 0);
  axis.step(100);
  ASSERT_EQ(axis.state(), quick_stop_active);
  axis.command(0x000F);
  EXPECT_EQ(axis.state(), operation_enabled);
}

// With habit g the drive looks for a mode when its time to power on is over: a mode that was
// withdrawn before does not count.
TEST(HabitModeBeforeEnabling, HoldsAtTheEndOfTheTimeToPowerOn) {
  for (const std::int64_t mode : {0, 3}) {
    SCOPED_TRACE(mode);
    AxisUnderTest axis;
    axis.write("habit_mode_before_enabling", 1);
    axis.write("habit_power_on_time", 50);
    axis.write("op_mode_cmd", 1);
    axis.command(0x000F);
    axis.write("op_mode_cmd", mode);
    axis.step(100);
    EXPECT_EQ(axis.state(), mode == 0 ? switched_on : operation_enabled);
  }
}

// ---- n: enabling clears the target velocity -----------------------------------------------------

TEST(HabitClearTargetVelocity, BeginsAtStandstill) {
  for (const std::int64_t habit : {0, 1}) {
    SCOPED_TRACE(habit);
    AxisUnderTest axis;
    axis.write("habit_clear_target_velocity", habit);
    axis.write("op_mode_cmd", 3);
    axis.write("target_velocity", 5'000);
    axis.command(0x000F);
    axis.step(100);
    EXPECT_EQ(axis.read("target_velocity"), habit == 0 ? 5'000 : 0);
    EXPECT_EQ(axis.demand_velocity(), habit == 0 ? 5'000 : 0);
    axis.write("target_velocity", 2'000);
    axis.step(100);
    EXPECT_EQ(axis.demand_velocity(), 2'000);
  }
}

// The inverter whose manual describes this habit is commanded through 6042h.
TEST(HabitClearTargetVelocity, ClearsThatOfTheVelocityModeToo) {
  for (const std::int64_t habit : {0, 1}) {
    SCOPED_TRACE(habit);
    AxisUnderTest axis;
    axis.write("habit_clear_target_velocity", habit);
    axis.write("op_mode_cmd", 2);
    axis.write("vl_target_velocity", 60);  // 4096 UU/s
    axis.command(0x007F);
    axis.step(100);
    EXPECT_EQ(axis.read("vl_target_velocity"), habit == 0 ? 60 : 0);
    EXPECT_EQ(axis.demand_velocity(), habit == 0 ? 4'096 : 0);
  }
}

}  // namespace
}  // namespace vdrive
