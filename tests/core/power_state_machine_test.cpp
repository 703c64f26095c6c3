// SPDX-License-Identifier: Apache-2.0
// The power state machine against an independent model: the reaction matrix and the transition
// table of CiA 402 as data, looked up by the masks of the command coding. First the machine alone
// for every word, then complete axes for every word and every event of a tick.
#include "vdrive/cia402/power_state_machine.hpp"

#include "core/support/axis_under_test.hpp"
#include "support/random_cases.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

// ---- the model ---------------------------------------------------------------------------------

/// Everything that decides the effect of a written word.
struct Situation {
  PowerState state = switch_on_disabled;
  PowerCommand pending = PowerCommand::none;  // ramp of 605Bh or 605Ch in progress
  std::uint16_t word = 0;
  bool previous_bit7 = false;
  PowerOptions options = {};
  bool voltage = true;
  bool cause_present = false;
};

struct Reaction {
  PowerState state;
  PowerCommand pending = PowerCommand::none;
  std::vector<unsigned> transitions = {};
};

/// Columns of the reaction matrix, in the order of decoding.
enum Column { kNothing, kReset, kDisableVoltage, kQuickStop, kShutdown, kSwitchOn, kEnable };

Column column_of(std::uint16_t word, bool previous_bit7) {
  struct Pattern {
    std::uint16_t mask;
    std::uint16_t value;
    Column column;
  };

  constexpr std::array<Pattern, 5> kPatterns{{{0x82, 0x00, kDisableVoltage},
                                              {0x86, 0x02, kQuickStop},
                                              {0x87, 0x06, kShutdown},
                                              {0x8F, 0x07, kSwitchOn},
                                              {0x8F, 0x0F, kEnable}}};
  for (const Pattern& pattern : kPatterns) {
    if ((word & pattern.mask) == pattern.value) return pattern.column;
  }
  return previous_bit7 ? kNothing : kReset;
}

/// One line of the reaction matrix: in `state` and column, these transitions lead to `next`.
struct Cell {
  PowerState state;
  Column column;
  std::vector<unsigned> transitions;
  PowerState next;
};

const std::vector<Cell>& matrix() {
  static const std::vector<Cell> cells{
      {switch_on_disabled, kShutdown, {2}, ready_to_switch_on},
      {switch_on_disabled, kEnable, {2, 3, 4}, operation_enabled},  // the manual's 0x0F
      {ready_to_switch_on, kDisableVoltage, {7}, switch_on_disabled},
      {ready_to_switch_on, kQuickStop, {7}, switch_on_disabled},
      {ready_to_switch_on, kSwitchOn, {3}, switched_on},
      {ready_to_switch_on, kEnable, {3, 4}, operation_enabled},
      {switched_on, kDisableVoltage, {10}, switch_on_disabled},
      {switched_on, kQuickStop, {10}, switch_on_disabled},
      {switched_on, kShutdown, {6}, ready_to_switch_on},
      {switched_on, kEnable, {4}, operation_enabled},
      {operation_enabled, kDisableVoltage, {9}, switch_on_disabled},
      {operation_enabled, kQuickStop, {11}, quick_stop_active},
      {operation_enabled, kShutdown, {8}, ready_to_switch_on},
      {operation_enabled, kSwitchOn, {5}, switched_on},
      {quick_stop_active, kDisableVoltage, {12}, switch_on_disabled},
      {quick_stop_active, kEnable, {16}, operation_enabled},  // 605Ah 5 to 8
      {fault, kReset, {15}, switch_on_disabled},
  };
  return cells;
}

/// The matrix as an array, for speed.
const Cell* cell_of(PowerState state, Column column) {
  static const auto kIndex = [] {
    std::array<std::array<const Cell*, 7>, 8> index{};
    for (const Cell& cell : matrix()) {
      index[static_cast<std::size_t>(cell.state)][cell.column] = &cell;
    }
    return index;
  }();
  return kIndex[static_cast<std::size_t>(state)][column];
}

Reaction expected_reaction(const Situation& s) {
  const Reaction stay{s.state, s.pending};
  const Column column = column_of(s.word, s.previous_bit7);
  const Cell* const cell = cell_of(s.state, column);
  if (cell == nullptr) return stay;
  const unsigned first = cell->transitions.front();
  const bool refused =
      (s.state == switch_on_disabled && !s.voltage) ||
      (first == 2 && column == kEnable && !s.options.enable_from_switch_on_disabled) ||
      (first == 16 && s.options.quick_stop_option_code < 5) || (first == 15 && s.cause_present);
  if (refused) return stay;
  // The ramps of 605Bh and 605Ch delay the transition. Shutdown is the stronger command of the two:
  // if it is pending, it remains.
  if (first == 8 && s.options.shutdown_option_code == 1) {
    return {s.state, PowerCommand::shutdown};
  }
  if (first == 5 && s.pending == PowerCommand::shutdown) return stay;
  if (first == 5 && s.options.disable_operation_option_code == 1) {
    return {s.state, PowerCommand::switch_on};
  }
  return {cell->next, PowerCommand::none, cell->transitions};
}

// ---- the machine alone -------------------------------------------------------------------------

/// A machine that its own events have brought into `state`.
PowerStateMachine machine_in(PowerState state, PowerCommand pending = PowerCommand::none) {
  PowerStateMachine machine;
  const PowerOptions ramps{.shutdown_option_code = 1, .disable_operation_option_code = 1};
  const auto command = [&machine, &ramps](PowerCommand what) {
    machine.command(what, ramps, true, false);
  };
  if (state == not_ready_to_switch_on) return machine;
  machine.initialised();
  if (state == switch_on_disabled) return machine;
  command(PowerCommand::shutdown);
  if (state == ready_to_switch_on) return machine;
  command(PowerCommand::switch_on);
  if (state == switched_on) return machine;
  command(PowerCommand::enable_operation);
  if (pending != PowerCommand::none) command(pending);
  if (state == quick_stop_active) {
    command(PowerCommand::quick_stop);
  } else if (state == fault_reaction_active || state == fault) {
    machine.fault_detected();
    if (state == fault) machine.stop_finished(ramps);
  }
  return machine;
}

std::uint32_t bits_of(const TransitionSet& set) {
  std::uint32_t bits = 0;
  for (unsigned number = 0; number <= 16; ++number) {
    bits |= set.contains(number) ? 1U << number : 0U;
  }
  return bits;
}

std::uint32_t bits_of(const std::vector<unsigned>& numbers) {
  std::uint32_t bits = 0;
  for (const unsigned number : numbers) bits |= 1U << number;
  return bits;
}

void expect_reaction(const PowerStateMachine& before, const Situation& s) {
  PowerStateMachine machine = before;
  const auto previous = static_cast<std::uint16_t>(s.previous_bit7 ? 0x0080 : 0x0000);
  const TransitionSet taken =
      machine.command(decode_command(s.word, previous), s.options, s.voltage, s.cause_present);

  const Reaction expected = expected_reaction(s);
  const bool equal = machine.state() == expected.state && machine.pending() == expected.pending &&
                     bits_of(taken) == bits_of(expected.transitions);
  ASSERT_TRUE(equal) << to_string(s.state) << ", pending " << static_cast<int>(s.pending)
                     << ", word 0x" << std::hex << s.word << ", bit 7 before " << s.previous_bit7
                     << ", 605Ah " << static_cast<int>(s.options.quick_stop_option_code)
                     << ", 605Bh " << static_cast<int>(s.options.shutdown_option_code) << ", 605Ch "
                     << static_cast<int>(s.options.disable_operation_option_code) << ", voltage "
                     << s.voltage << ", cause " << s.cause_present << ": "
                     << to_string(machine.state()) << " instead of " << to_string(expected.state)
                     << ", transitions 0x" << bits_of(taken) << " instead of 0x"
                     << bits_of(expected.transitions);
}

struct Start {
  PowerState state;
  PowerCommand pending;
};

constexpr std::array<Start, 10> kStarts{{
    {not_ready_to_switch_on, PowerCommand::none},
    {switch_on_disabled, PowerCommand::none},
    {ready_to_switch_on, PowerCommand::none},
    {switched_on, PowerCommand::none},
    {operation_enabled, PowerCommand::none},
    {operation_enabled, PowerCommand::shutdown},
    {operation_enabled, PowerCommand::switch_on},
    {quick_stop_active, PowerCommand::none},
    {fault_reaction_active, PowerCommand::none},
    {fault, PowerCommand::none},
}};

TEST(PowerStateMachine, EveryControlwordInEveryStateFollowsTheReactionMatrix) {
  for (const Start& start : kStarts) {
    const PowerStateMachine machine = machine_in(start.state, start.pending);
    ASSERT_EQ(machine.state(), start.state);
    ASSERT_EQ(machine.pending(), start.pending);
    for (std::uint32_t i = 0; i < 8U * 0x10000U; ++i) {
      const Situation situation{.state = start.state,
                                .pending = start.pending,
                                .word = static_cast<std::uint16_t>(i),
                                .previous_bit7 = (i & 0x10000U) != 0,
                                .options = {},
                                .voltage = (i & 0x20000U) == 0,
                                .cause_present = (i & 0x40000U) != 0};
      ASSERT_NO_FATAL_FAILURE(expect_reaction(machine, situation));
    }
  }
}

TEST(PowerStateMachine, EveryOptionCodeAndSettingFollowsTheSpecification) {
  for (const Start& start : kStarts) {
    const PowerStateMachine machine = machine_in(start.state, start.pending);
    for (std::int8_t quick_stop = 0; quick_stop <= 8; ++quick_stop) {
      for (std::uint32_t i = 0; i < 64U * 0x100U; ++i) {
        const Situation situation{
            .state = start.state,
            .pending = start.pending,
            .word = static_cast<std::uint16_t>(i & 0xFFU),
            .previous_bit7 = (i & 0x100U) != 0,
            .options = {.quick_stop_option_code = quick_stop,
                        .shutdown_option_code = static_cast<std::int8_t>(i >> 9U & 1U),
                        .disable_operation_option_code = static_cast<std::int8_t>(i >> 10U & 1U),
                        .enable_from_switch_on_disabled = (i & 0x800U) != 0},
            .voltage = (i & 0x1000U) != 0,
            .cause_present = (i & 0x2000U) != 0};
        ASSERT_NO_FATAL_FAILURE(expect_reaction(machine, situation));
      }
    }
  }
}

TEST(PowerStateMachine, AFaultLeadsFromEveryStateToFaultReactionActiveOnce) {
  for (const Start& start : kStarts) {
    PowerStateMachine machine = machine_in(start.state, start.pending);
    const TransitionSet taken = machine.fault_detected();

    const bool handled = start.state == fault || start.state == fault_reaction_active;
    EXPECT_EQ(bits_of(taken), handled ? 0U : 1U << 13U) << to_string(start.state);
    EXPECT_EQ(machine.state(), start.state == fault ? fault : fault_reaction_active);
    EXPECT_EQ(machine.pending(), PowerCommand::none);
  }
}

TEST(PowerStateMachine, ALostDcLinkLeadsToSwitchOnDisabledFromStatesWithoutPower) {
  for (const Start& start : kStarts) {
    PowerStateMachine machine = machine_in(start.state, start.pending);
    const TransitionSet taken = machine.voltage_lost();

    std::uint32_t expected = 0;
    if (start.state == ready_to_switch_on) {
      expected = 1U << 7U;
    } else if (start.state == switched_on) {
      expected = 1U << 10U;
    }
    EXPECT_EQ(bits_of(taken), expected) << to_string(start.state);
    EXPECT_EQ(machine.state(), expected == 0 ? start.state : switch_on_disabled);
  }
}

TEST(PowerStateMachine, APowerStageThatDropsOutTakesTransition5WhateverWaits) {
  for (const Start& start : kStarts) {
    PowerStateMachine machine = machine_in(start.state, start.pending);
    const TransitionSet taken = machine.power_dropped();

    const bool is_enabled = start.state == operation_enabled;
    EXPECT_EQ(bits_of(taken), is_enabled ? 1U << 5U : 0U) << to_string(start.state);
    EXPECT_EQ(machine.state(), is_enabled ? switched_on : start.state);
    EXPECT_EQ(machine.pending(), PowerCommand::none) << to_string(start.state);
  }
}

TEST(PowerStateMachine, TheEndOfAStopTriggersTheTransitionOfItsState) {
  for (const Start& start : kStarts) {
    for (std::int8_t option = 0; option <= 8; ++option) {
      PowerStateMachine machine = machine_in(start.state, start.pending);
      const TransitionSet taken = machine.stop_finished({.quick_stop_option_code = option});

      std::uint32_t expected = 0;
      PowerState next = start.state;
      if (start.state == fault_reaction_active) {
        expected = 1U << 14U;
        next = fault;
      } else if (start.state == quick_stop_active && option <= 4) {
        expected = 1U << 12U;
        next = switch_on_disabled;
      } else if (start.pending == PowerCommand::shutdown) {
        expected = 1U << 8U;
        next = ready_to_switch_on;
      } else if (start.pending == PowerCommand::switch_on) {
        expected = 1U << 5U;
        next = switched_on;
      }
      EXPECT_EQ(bits_of(taken), expected) << to_string(start.state);
      EXPECT_EQ(machine.state(), next);
    }
  }
}

TEST(PowerStateMachine, InitialisingLeavesOnlyNotReadyToSwitchOn) {
  for (const Start& start : kStarts) {
    PowerStateMachine machine = machine_in(start.state, start.pending);
    const TransitionSet taken = machine.initialised();
    const bool first = start.state == not_ready_to_switch_on;
    EXPECT_EQ(bits_of(taken), first ? 1U << 1U : 0U);
    EXPECT_EQ(machine.state(), first ? switch_on_disabled : start.state);
  }
}

// ---- on a complete axis ------------------------------------------------------------------------

TEST(ReactionMatrix, T5DisableOperationAtRestEndsWithinTwoTicks) {
  AxisUnderTest axis;
  axis.enable();
  axis.controlword(0x0007);
  EXPECT_NE(axis.step_until_status(0x006F, 0x0023, 2), 0U);
  EXPECT_EQ(axis.statusword(), 0x0233) << "the manual's 563";
}

// ---- every word x previous bit 7 x {nothing, fault, master silent, DC link lost} ---------------

enum class Event { nothing, fault, master_silent, dc_link_lost };

constexpr std::size_t kBankAxes = 256;

/// Brings an axis of the bank into `state`, with bit 7 of the controlword as given.
class StateDriver {
 public:
  StateDriver() : bank_(std::vector<AxisConfiguration>(kBankAxes), std::chrono::milliseconds{1}) {}

  AxisBank& bank() { return bank_; }

  void drive_all(PowerState state, bool bit7, bool stays_in_quick_stop) {
    write("op_mode_cmd", 1);
    write("quick_stop_option_code", stays_in_quick_stop ? 6 : 2);
    write("quick_stop_deceleration", 1'000'000);  // from 24000/s in 24 ms
    write("disable_operation_option_code", 0);
    if (state == not_ready_to_switch_on) {
      for (std::size_t axis = 0; axis < kBankAxes; ++axis) bank_.power_cycle(axis);
      write("quick_stop_option_code", stays_in_quick_stop ? 6 : 2);
      write("disable_operation_option_code", 0);
    } else if (state == ready_to_switch_on) {
      command(0x06);
    } else if (state == switched_on) {
      command(0x06);
      command(0x07);
    } else if (state != switch_on_disabled) {
      drive_moving(state, bit7);
    }
    if (bit7) {
      write("ds402_controlword", 0x80);  // no command: only the edge counts, and only in Fault
    }
  }

 private:
  void write(std::string_view name, std::int64_t value) {
    for (std::size_t axis = 0; axis < kBankAxes; ++axis) {
      bank_.write(axis, AxisUnderTest::address_of(name), value);
    }
  }

  void command(std::uint16_t word) {
    write("ds402_controlword", word);
    bank_.step();
  }

  void step(int ticks) {
    for (int i = 0; i < ticks; ++i) bank_.step();
  }

  void drive_moving(PowerState state, bool bit7) {
    command(0x0F);
    write("position_user_target_value", 10000);
    command(0x1F);
    step(60);
    if (state == quick_stop_active) {
      command(0x02);
    } else if (state == fault_reaction_active || state == fault) {
      if (bit7) {
        command(0x80);  // before the fault, so that it is not an edge in Fault
      }
      write("test_over_current", 1);
      step(1);
      write("test_over_current", 0);
      step(state == fault ? 100 : 0);
    }
  }

  AxisBank bank_;
};

/// @return the state after one tick with this state, word and event, by the tables above.
PowerState expected_after_tick(PowerState from, const Situation& word, Event event) {
  Situation s = word;
  s.state = from;
  s.voltage = event != Event::dc_link_lost;
  s.cause_present = event == Event::fault || event == Event::dc_link_lost;
  const bool controlled = from == operation_enabled || from == quick_stop_active;
  if (event == Event::master_silent && controlled) {
    s.state = fault_reaction_active;  // 6007h = 1
  }
  PowerState state = expected_reaction(s).state;
  if (state == not_ready_to_switch_on) state = switch_on_disabled;
  const bool faulty = state == fault || state == fault_reaction_active;
  if (event == Event::fault && !faulty) return fault_reaction_active;
  if (event == Event::dc_link_lost) {
    if (state == operation_enabled || state == quick_stop_active) return fault_reaction_active;
    return faulty ? state : switch_on_disabled;
  }
  return state;
}

void sweep_words(PowerState from, bool bit7, bool stays, Event event) {
  StateDriver driver;
  AxisBank& bank = driver.bank();
  driver.drive_all(from, bit7, stays);
  ASSERT_EQ(bank.power_state(0), from);
  const AxisBank::Snapshot start = bank.snapshot();
  const ObjectAddress controlword = AxisUnderTest::address_of("ds402_controlword");
#ifdef __OPTIMIZE__
  constexpr std::uint32_t kStride = 1;
#else
  constexpr std::uint32_t kStride = 16;  // every low byte, with every 16th high byte
#endif
  for (std::uint32_t high = 0; high < 256; high += kStride) {
    bank.restore(start);
    for (std::size_t axis = 0; axis < kBankAxes; ++axis) {
      if (event == Event::fault) {
        bank.write(axis, AxisUnderTest::address_of("test_over_current"), 1);
      } else if (event == Event::dc_link_lost) {
        bank.write(axis, AxisUnderTest::address_of("test_dc_link_loss"), 1);
      } else if (event == Event::master_silent) {
        bank.report_connection_loss(axis);
      }
      bank.write(axis, controlword, static_cast<std::int64_t>(high << 8U | axis));
    }
    bank.step();
    for (std::size_t axis = 0; axis < kBankAxes; ++axis) {
      Situation word{.word = static_cast<std::uint16_t>(high << 8U | axis), .previous_bit7 = bit7};
      word.options.quick_stop_option_code = stays ? 6 : 2;
      word.options.disable_operation_option_code = 0;
      const PowerState expected = expected_after_tick(from, word, event);
      const PowerState shown = decode_power_state(bank.status(axis).ds402_statusword);
      ASSERT_EQ(shown, expected) << to_string(from) << ", word 0x" << std::hex << word.word
                                 << ", bit 7 before " << bit7 << ", event "
                                 << static_cast<int>(event) << ": " << to_string(shown)
                                 << " instead of " << to_string(expected);
      ASSERT_EQ(bank.power_state(axis), expected);
    }
  }
}

class EveryControlword : public testing::TestWithParam<PowerState> {};

TEST_P(EveryControlword, FollowsTheTablesTogetherWithAnyOtherEventOfTheTick) {
  for (const bool bit7 : {false, true}) {
    for (const Event event :
         {Event::nothing, Event::fault, Event::master_silent, Event::dc_link_lost}) {
      ASSERT_NO_FATAL_FAILURE(sweep_words(GetParam(), bit7, false, event));
      if (GetParam() == quick_stop_active) {
        ASSERT_NO_FATAL_FAILURE(sweep_words(GetParam(), bit7, true, event));
      }
    }
  }
}

std::string name_of_state(const testing::TestParamInfo<PowerState>& info) {
  std::string name = "In_" + std::string(to_string(info.param));
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(PowerStateMachine, EveryControlword,
                         testing::Values(not_ready_to_switch_on, switch_on_disabled,
                                         ready_to_switch_on, switched_on, operation_enabled,
                                         quick_stop_active, fault_reaction_active, fault),
                         name_of_state);

// ---- random walks ------------------------------------------------------------------------------

struct OptionObject {
  const char* name;
  std::int64_t lowest;
  std::int64_t highest;
  std::int64_t default_value;
};

/// The option codes of the walk; the indices below follow this order.
constexpr std::array<OptionObject, 6> kOptions{{{"quick_stop_option_code", 0, 8, 2},
                                                {"shutdown_option_code", 0, 1, 0},
                                                {"disable_operation_option_code", 0, 1, 1},
                                                {"halt_option_code", 1, 4, 1},
                                                {"fault_reaction_option_code", 0, 4, 2},
                                                {"abort_connection_option_code", 0, 3, 1}}};

enum Option { k605A, k605B, k605C, k605D, k605E, k6007 };

// Ramps that a single tick can tell apart: they reduce the speed by 400, 800 and 1600 units/s.
constexpr double kNormalRamp = 400'000.0;      // 6084h
constexpr double kQuickRamp = 800'000.0;       // 6085h
constexpr double kSteepestRamp = 1'600'000.0;  // 60C6h

constexpr std::array<const char*, 4> kCauses{"test_over_current", "test_over_temperature",
                                             "test_encoder_failure", "test_dc_link_loss"};
constexpr std::size_t kEncoderFailure = 2;
constexpr std::size_t kDcLinkLoss = 3;

bool controlled(PowerState state) {
  return state == operation_enabled || state == quick_stop_active;
}

/// The ramp of a stop by its option code: 1 normal, 2 quick, 3 and 4 steepest.
double ramp_of(std::int64_t option) {
  return option == 1 ? kNormalRamp : (option == 2 ? kQuickRamp : kSteepestRamp);
}

/// Counts of the walk: each value of each option code must meet the event that reads it.
struct WalkCounts {
  std::array<std::array<std::uint64_t, 9>, kOptions.size()> event{};    // read while the axis moves
  std::array<std::array<std::uint64_t, 9>, kOptions.size()> braking{};  // ticks on its ramp
  std::array<std::uint64_t, 17> transitions{};
};

/// State, power and pending ramp of an axis by the tables above; it takes only the speeds, which
/// end the stops, from the drive.
class WalkModel {
 public:
  explicit WalkModel(WalkCounts& counts) : counts_(counts) { power_up(); }

  void power_up() {
    for (std::size_t i = 0; i < kOptions.size(); ++i) options_[i] = kOptions[i].default_value;
    state_ = not_ready_to_switch_on;
    pending_ = PowerCommand::none;
    powered_ = false;
    coasting_ = false;
    word_ = 0;
    mode_ = 0;
    mode_command_ = 0;
  }

  void option(std::size_t which, std::int64_t value) { options_[which] = value; }

  void cause(std::size_t which, bool present) { present_[which] = present; }

  void mode_command(std::int64_t mode) { mode_command_ = mode; }

  /// A written controlword.
  void controlword(std::uint16_t word) {
    Situation s{.state = state_, .pending = pending_, .word = word};
    s.previous_bit7 = (word_ & 0x80U) != 0;
    s.options.quick_stop_option_code = static_cast<std::int8_t>(options_[k605A]);
    s.options.shutdown_option_code = static_cast<std::int8_t>(options_[k605B]);
    s.options.disable_operation_option_code = static_cast<std::int8_t>(options_[k605C]);
    s.voltage = !present_[kDcLinkLoss];
    s.cause_present = any_cause();
    const Column column = column_of(word, s.previous_bit7);
    if (state_ == operation_enabled && column == kShutdown) {
      count_event(k605B);
    } else if (state_ == operation_enabled && column == kSwitchOn &&
               pending_ != PowerCommand::shutdown) {
      count_event(k605C);
    }
    if ((word & ~word_ & 0x100U) != 0 && state_ == operation_enabled && mode_ == 1) {
      count_event(k605D);
    }
    word_ = word;
    const Reaction reaction = expected_reaction(s);
    for (const unsigned number : reaction.transitions) take(number, reaction.state);
    pending_ = reaction.pending;
  }

  void master_silent() {
    if (!controlled(state_)) return;
    count_event(k6007);
    if (options_[k6007] == 1) {
      fault(false);
    } else if (options_[k6007] == 2) {
      take(state_ == operation_enabled ? 9 : 12, switch_on_disabled);
    } else if (options_[k6007] == 3 && state_ == operation_enabled) {
      take(11, quick_stop_active);
    }
  }

  /// Automatic transitions at the start of a tick. `may_end` and `must_end` tell, from the speeds
  /// of the last tick, whether a stop may or must end. They differ by rounding; if it may but need
  /// not, the state that the drive shows after the tick decides.
  void begin_tick(bool may_end, bool must_end, PowerState shown, bool shown_power) {
    if (state_ == not_ready_to_switch_on) take(1, switch_on_disabled);
    const bool faulted = shown == fault_reaction_active && (shown_power || !voltage());
    end_stop(may_end, must_end || (shown != state_ && !faulted));
    for (std::size_t i = 0; i < kCauses.size(); ++i) {
      const bool harmless =
          i == kDcLinkLoss && !controlled(state_) && state_ != fault_reaction_active;
      if (present_[i] && !harmless) fault(i == kEncoderFailure || i == kDcLinkLoss);
    }
    if (present_[kDcLinkLoss] && (state_ == ready_to_switch_on || state_ == switched_on)) {
      take(state_ == switched_on ? 10 : 7, switch_on_disabled);
    }
    entered_ = false;
  }

  /// After the tick: takes over the speeds for the next one.
  void end_tick(double speed, std::int64_t mode) {
    speed_ = speed;
    mode_ = mode;
  }

  /// @return |606Bh| from which the tick continues: that of the last tick, unless the demand was
  ///         set to rest.
  [[nodiscard]] double speed() const { return speed_; }

  /// @return the ramp that the demand must follow in this tick; 0 if the walk does not know it.
  double ramp() {
    if (!powered_) return 0.0;
    if (state_ == quick_stop_active) {
      const std::int64_t code = options_[k605A];
      return counted(k605A, ramp_of(code > 4 ? code - 4 : code));
    }
    if (state_ == fault_reaction_active) return counted(k605E, ramp_of(options_[k605E]));
    if (pending_ != PowerCommand::none) {
      return counted(pending_ == PowerCommand::shutdown ? k605B : k605C, kNormalRamp);
    }
    if (state_ == operation_enabled && mode_ == 1 && mode_command_ == 1 && (word_ & 0x100U) != 0) {
      return counted(k605D, ramp_of(options_[k605D]));
    }
    return 0.0;
  }

  [[nodiscard]] PowerState state() const { return state_; }

  [[nodiscard]] bool powered() const { return powered_; }

  [[nodiscard]] bool voltage() const { return !present_[kDcLinkLoss]; }

 private:
  [[nodiscard]] bool any_cause() const {
    return std::find(present_.begin(), present_.end(), true) != present_.end();
  }

  /// Counts an event that reads option code `which` while the axis moves.
  void count_event(std::size_t which) {
    if (speed_ > 2'000.0) ++counts_.event[which][static_cast<std::size_t>(options_[which])];
  }

  double counted(std::size_t which, double ramp) {
    if (speed_ > 2'000.0) ++counts_.braking[which][static_cast<std::size_t>(options_[which])];
    return ramp;
  }

  void take(unsigned number, PowerState next) {
    ++counts_.transitions[number];
    const bool was_powered = powered_;
    if (number == 11) count_event(k605A);
    state_ = next;
    pending_ = PowerCommand::none;
    entered_ = true;
    const bool keeps = (number == 11 && options_[k605A] != 0) ||
                       (number == 13 && options_[k605E] != 0 && !coasting_);
    powered_ = number == 4 || number == 16 || (keeps && was_powered);
    if (number == 4 || !powered_) {
      speed_ = 0.0;  // without power, and on enabling, the demand is at rest
    }
    coasting_ = coasting_ && number != 15;
  }

  void fault(bool coasting) {
    coasting_ = coasting_ || coasting;
    if (state_ != PowerState::fault && state_ != fault_reaction_active) {
      if (powered_ && !coasting_) count_event(k605E);
      take(13, fault_reaction_active);
    }
    powered_ = powered_ && !coasting_;
  }

  void end_stop(bool may_end, bool ended) {
    const bool stays = state_ == quick_stop_active && options_[k605A] >= 5;
    const bool stopping = state_ == quick_stop_active || state_ == fault_reaction_active ||
                          pending_ != PowerCommand::none;
    if (!stopping || stays || entered_) return;
    if (powered_ && !(may_end && ended)) return;
    unsigned number = 14;
    PowerState next = PowerState::fault;
    if (state_ == quick_stop_active) {
      number = 12;
      next = switch_on_disabled;
    } else if (state_ == operation_enabled) {
      number = pending_ == PowerCommand::shutdown ? 8 : 5;
      next = number == 8 ? ready_to_switch_on : switched_on;
    }
    take(number, next);
  }

  WalkCounts& counts_;
  std::array<std::int64_t, kOptions.size()> options_{};
  std::array<bool, kCauses.size()> present_{};
  PowerState state_ = not_ready_to_switch_on;
  PowerCommand pending_ = PowerCommand::none;
  std::uint16_t word_ = 0;
  std::int64_t mode_ = 0;
  std::int64_t mode_command_ = 0;
  double speed_ = 0.0;  // |606Bh| of the last tick
  bool powered_ = false;
  bool coasting_ = false;
  bool entered_ = false;  // the state was entered after the last tick
};

/// A walk: the same writes to an axis and to the model.
class Walk {
 public:
  Walk() : model_(counts_) {
    model_.begin_tick(false, false, switch_on_disabled, false);  // the axis is powered up already
    configure();
  }

  /// Writes and runs one tick. Fails at the first difference.
  void tick() {
    if (random_.one_in(20'000)) {
      axis_.axis().power_cycle();
      model_.power_up();
      configure();
    }
    write_causes();
    if (random_.one_in(12)) write_parameters();
    while (random_.one_in(6)) write_word();
    write_causes();
    if (random_.one_in(150)) {
      axis_.axis().report_connection_loss();
      model_.master_silent();
    }
    step_and_compare();
  }

  [[nodiscard]] const WalkCounts& counts() const { return counts_; }

 private:
  void write(ObjectAddress object, std::int64_t value) {
    ASSERT_EQ(axis_.axis().write(object, value), AbortCode::none);
  }

  void configure() {
    axis_.write("profile_acc", 4'000'000);
    axis_.write("profile_dec", static_cast<std::int64_t>(kNormalRamp));
    axis_.write("quick_stop_deceleration", static_cast<std::int64_t>(kQuickRamp));
    axis_.write("app_dec_limit", static_cast<std::int64_t>(kSteepestRamp));
    axis_.write("profile_velocity", 30'000);
    axis_.write("following_error_window", 0xFFFFFFFF);
  }

  void write_causes() {
    for (std::size_t i = 0; i < kCauses.size(); ++i) {
      if (random_.one_in(cause_[i] ? 20 : 1'500)) {
        cause_[i] = !cause_[i];
        write(kCauseAddresses[i], cause_[i] ? 1 : 0);
        model_.cause(i, cause_[i]);
      }
    }
  }

  void write_parameters() {
    const std::size_t which = random_.below(kOptions.size());
    const OptionObject& object = kOptions[which];
    const auto values = static_cast<std::uint64_t>(object.highest - object.lowest + 1);
    const std::int64_t value = object.lowest + static_cast<std::int64_t>(random_.below(values));
    write(kOptionAddresses[which], value);
    model_.option(which, value);
    const std::int64_t mode = random_.one_in(6) ? 0 : 1;
    write(kMode, mode);
    model_.mode_command(mode);
    write(kTarget, static_cast<std::int64_t>(random_.below(2'000'000)) - 1'000'000);
  }

  /// Mostly words with an effect, most of them towards motion that can be stopped; sometimes any.
  void write_word() {
    static constexpr std::array<std::uint16_t, 24> kWords{
        0x0F, 0x1F, 0x3F,   0x0F, 0x3F, 0x0F, 0x1F, 0x3F, 0x0F,   0x3F,   0x7F,   0x0F,
        0x3F, 0x80, 0x010F, 0x8F, 0x86, 0x06, 0x07, 0x02, 0x013F, 0x0102, 0x0000, 0x011F};
    const auto word = random_.one_in(16) ? static_cast<std::uint16_t>(random_.bits())
                                         : kWords[random_.below(kWords.size())];
    write(kControlword, word);
    model_.controlword(word);
  }

  void step_and_compare() {
    const AxisStatus& s = axis_.status();
    const double before = std::abs(static_cast<double>(s.velocity_demand_value));
    // The end of a stop (docs/explanation/decisions.md): 606Bh = 0 and |606Ch| within 606Fh = 10,
    // which a load may prevent for up to one second. 606Bh shows 0 half a unit early; 606Ch is
    // rounded.
    quiet_ticks_ = before == 0.0 ? quiet_ticks_ + 1 : 0;
    const int actual = std::abs(s.load_velocity_actual_value);
    const bool may_end = before == 0.0 && (actual <= 10 || quiet_ticks_ >= 1'000);
    const bool must_end = quiet_ticks_ >= 3 && actual < 10;
    axis_.step();
    model_.begin_tick(may_end, must_end, axis_.state(), s.motor_op_status != 0);

    const PowerState now = axis_.state();
    ASSERT_EQ(now, model_.state()) << to_string(now) << " instead of " << to_string(model_.state());
    ASSERT_EQ(now, axis_.axis().power_state());
    const unsigned word = statusword_of(model_.state()) | Statusword::kRemote |
                          (model_.voltage() ? Statusword::kVoltageEnabled : 0U);
    constexpr unsigned kMotion = Statusword::kTargetReached | Statusword::kSetPointAcknowledge;
    const std::uint16_t shown = axis_.statusword();
    ASSERT_EQ(shown & ~kMotion, word) << std::hex << shown;
    ASSERT_TRUE(controlled(now) || (shown & Statusword::kTargetReached) == 0);
    ASSERT_TRUE(now == operation_enabled || !axis_.acknowledged());
    ASSERT_EQ(s.motor_op_status, model_.powered() ? 1 : 0);
    ASSERT_TRUE(model_.powered() ||
                (s.current_actual_value == 0 && axis_.demand() == axis_.actual()));
    compare_ramp();
    model_.end_tick(std::abs(static_cast<double>(s.velocity_demand_value)), s.op_mode_actual);
  }

  /// Checks that 606Bh is on the ramp of the stop in force, with two roundings of half a unit.
  void compare_ramp() {
    const double before = model_.speed();
    const double ramp = model_.ramp();
    if (ramp == 0.0) return;
    const double after = std::abs(static_cast<double>(axis_.demand_velocity()));
    ASSERT_NEAR(after, std::max(before - ramp * 1.0e-3, 0.0), 1.01);
  }

  static constexpr std::array<ObjectAddress, 4> kCauseAddresses{
      {{0x5E02, 0}, {0x5E03, 0}, {0x5E04, 0}, {0x5E05, 0}}};
  static constexpr std::array<ObjectAddress, 6> kOptionAddresses{
      {{0x605A, 0}, {0x605B, 0}, {0x605C, 0}, {0x605D, 0}, {0x605E, 0}, {0x6007, 0}}};
  static constexpr ObjectAddress kControlword{0x6040, 0};
  static constexpr ObjectAddress kMode{0x6060, 0};
  static constexpr ObjectAddress kTarget{0x607A, 0};

  test::Random random_{20240611};
  AxisUnderTest axis_;
  WalkCounts counts_;
  WalkModel model_;
  std::array<bool, 4> cause_{};
  std::uint64_t quiet_ticks_ = 0;
};

void expect_every_option_exercised(const WalkCounts& counts) {
  for (std::size_t i = 0; i < kOptions.size(); ++i) {
    for (std::int64_t value = kOptions[i].lowest; value <= kOptions[i].highest; ++value) {
      SCOPED_TRACE(std::string(kOptions[i].name) + " = " + std::to_string(value));
      const auto at = static_cast<std::size_t>(value);
      EXPECT_GE(counts.event[i][at], 10U) << "times its event met the axis in motion";
      // 0 disables immediately; 6007h has no ramp.
      const bool brakes = i != k6007 && value != 0;
      EXPECT_TRUE(!brakes || counts.braking[i][at] >= 50U)
          << counts.braking[i][at] << " ticks on its ramp";
    }
  }
  for (unsigned number = 1; number <= 16; ++number) {
    EXPECT_GE(counts.transitions[number], 1U) << "transition " << number;
  }
}

// A million ticks in an optimised build, a tenth of that otherwise (sanitizers).
TEST(PowerStateMachine, ARandomWalkFollowsTheTablesInEveryTickAndCoversEveryOptionCode) {
  Walk walk;
  const std::uint64_t ticks = test::case_count(1'000'000, 10'000'000);
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    ASSERT_NO_FATAL_FAILURE(walk.tick()) << "tick " << tick;
    if (testing::Test::HasFailure()) FAIL() << "tick " << tick;
  }
  expect_every_option_exercised(walk.counts());
}

}  // namespace
}  // namespace vdrive
