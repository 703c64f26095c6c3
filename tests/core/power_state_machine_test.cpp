// SPDX-License-Identifier: Apache-2.0
// The power state machine against an independent model: the reaction matrix and the transition
// table of CiA 402 as data, looked up by the masks of the command coding. First the machine by
// itself for every word, then whole axes for every word and every event of a tick.
#include "vdrive/cia402/power_state_machine.hpp"

#include "core/support/axis_under_test.hpp"
#include "core/support/random_cases.hpp"
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

// ---- the model
// ------------------------------------------------------------------------------------

/// Everything that decides what a written word does.
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
    if ((word & pattern.mask) == pattern.value) {
      return pattern.column;
    }
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
  if (cell == nullptr) {
    return stay;
  }
  const unsigned first = cell->transitions.front();
  const bool refused =
      (s.state == switch_on_disabled && !s.voltage) ||
      (first == 2 && column == kEnable && !s.options.enable_from_switch_on_disabled) ||
      (first == 16 && s.options.quick_stop_option_code < 5) || (first == 15 && s.cause_present);
  if (refused) {
    return stay;
  }
  // Ramps of 605Bh and 605Ch hold the transition back; the stronger one stays.
  if (first == 8 && s.options.shutdown_option_code == 1) {
    return {s.state, PowerCommand::shutdown};
  }
  if (first == 5 && s.pending == PowerCommand::shutdown) {
    return stay;
  }
  if (first == 5 && s.options.disable_operation_option_code == 1) {
    return {s.state, PowerCommand::switch_on};
  }
  return {cell->next, PowerCommand::none, cell->transitions};
}

// ---- the machine by itself
// ------------------------------------------------------------------------

/// A machine in `state`, by way of its own events.
PowerStateMachine machine_in(PowerState state, PowerCommand pending = PowerCommand::none) {
  PowerStateMachine machine;
  const PowerOptions ramps{.shutdown_option_code = 1, .disable_operation_option_code = 1};
  const auto command = [&machine, &ramps](PowerCommand what) {
    machine.command(what, ramps, true, false);
  };
  if (state == not_ready_to_switch_on) {
    return machine;
  }
  machine.initialised();
  if (state == switch_on_disabled) {
    return machine;
  }
  command(PowerCommand::shutdown);
  if (state == ready_to_switch_on) {
    return machine;
  }
  command(PowerCommand::switch_on);
  if (state == switched_on) {
    return machine;
  }
  command(PowerCommand::enable_operation);
  if (pending != PowerCommand::none) {
    command(pending);
  }
  if (state == quick_stop_active) {
    command(PowerCommand::quick_stop);
  } else if (state == fault_reaction_active || state == fault) {
    machine.fault_detected();
    if (state == fault) {
      machine.stop_finished(ramps);
    }
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
  for (const unsigned number : numbers) {
    bits |= 1U << number;
  }
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

TEST(PowerStateMachine, EveryWordInEveryStateDoesWhatTheReactionMatrixSays) {
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

TEST(PowerStateMachine, EveryOptionCodeAndSettingDoesWhatTheSheetSays) {
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

TEST(PowerStateMachine, ALostDcLinkFallsToSwitchOnDisabledFromTheStatesWithoutPower) {
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

TEST(PowerStateMachine, TheEndOfAStopTakesTheTransitionOfItsState) {
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

TEST(PowerStateMachine, InitialisingLeavesNotReadyToSwitchOnAndNothingElse) {
  for (const Start& start : kStarts) {
    PowerStateMachine machine = machine_in(start.state, start.pending);
    const TransitionSet taken = machine.initialised();
    const bool first = start.state == not_ready_to_switch_on;
    EXPECT_EQ(bits_of(taken), first ? 1U << 1U : 0U);
    EXPECT_EQ(machine.state(), first ? switch_on_disabled : start.state);
  }
}

// ---- the matrix, cell by cell, on a whole axis
// ----------------------------------------------------

struct MatrixRow {
  const char* name;
  PowerState from;
  std::uint16_t word;
  PowerState to;
};

/// Drives an axis into `state` and holds it there: the fault reaction and the quick stop brake.
void drive_to(AxisUnderTest& axis, PowerState state) {
  axis.write("op_mode_cmd", 1);
  axis.write("profile_velocity", 100000);
  axis.write("quick_stop_deceleration", 100000);  // a second to brake
  switch (state) {
    case not_ready_to_switch_on:
      axis.axis().power_cycle();
      return;
    case switch_on_disabled:
      axis.command(0x0000);
      return;
    case ready_to_switch_on:
      axis.command(0x0006);
      return;
    case switched_on:
      axis.command(0x0006);
      axis.command(0x0007);
      return;
    default:
      break;
  }
  axis.command(0x000F);
  if (state == operation_enabled) {
    return;
  }
  axis.write("position_user_target_value", 1000000);
  axis.command(0x001F);
  axis.step(300);
  if (state == quick_stop_active) {
    axis.command(0x0002);
    return;
  }
  axis.write("test_over_current", 1);
  axis.step();
  axis.write("test_over_current", 0);
  if (state == fault) {
    axis.step_until(
        [&axis] {
          return axis.state() == fault;
        },
        5000);
  }
}

class ReactionMatrix : public testing::TestWithParam<MatrixRow> {};

TEST_P(ReactionMatrix, HoldsOnAnAxis) {
  const MatrixRow& row = GetParam();
  AxisUnderTest axis;
  drive_to(axis, row.from);
  ASSERT_EQ(axis.axis().power_state(), row.from);

  axis.controlword(row.word);

  EXPECT_EQ(axis.axis().power_state(), row.to);
}

std::string name_of(const testing::TestParamInfo<MatrixRow>& info) {
  return info.param.name;
}

// 605Ah, 605Bh, 605Ch at their defaults 2, 0, 1: Disable operation brakes first, at rest it is done
// in the next tick (below).
INSTANTIATE_TEST_SUITE_P(
    PowerStateMachine, ReactionMatrix,
    testing::Values(
        MatrixRow{"switch_on_disabled_ignores_disable_voltage", switch_on_disabled, 0x00,
                  switch_on_disabled},
        MatrixRow{"switch_on_disabled_ignores_quick_stop", switch_on_disabled, 0x0B,
                  switch_on_disabled},
        MatrixRow{"T2_switch_on_disabled_shutdown", switch_on_disabled, 0x06, ready_to_switch_on},
        MatrixRow{"switch_on_disabled_ignores_switch_on", switch_on_disabled, 0x07,
                  switch_on_disabled},
        MatrixRow{"T2_T3_T4_switch_on_disabled_enable_operation", switch_on_disabled, 0x0F,
                  operation_enabled},
        MatrixRow{"switch_on_disabled_ignores_fault_reset", switch_on_disabled, 0x80,
                  switch_on_disabled},
        MatrixRow{"T7_ready_to_switch_on_disable_voltage", ready_to_switch_on, 0x05,
                  switch_on_disabled},
        MatrixRow{"T7_ready_to_switch_on_quick_stop", ready_to_switch_on, 0x02, switch_on_disabled},
        MatrixRow{"ready_to_switch_on_keeps_on_shutdown", ready_to_switch_on, 0x06,
                  ready_to_switch_on},
        MatrixRow{"T3_ready_to_switch_on_switch_on", ready_to_switch_on, 0x07, switched_on},
        MatrixRow{"T3_T4_ready_to_switch_on_enable_operation", ready_to_switch_on, 0x0F,
                  operation_enabled},
        MatrixRow{"T10_switched_on_disable_voltage", switched_on, 0x00, switch_on_disabled},
        MatrixRow{"T10_switched_on_quick_stop", switched_on, 0x0B, switch_on_disabled},
        MatrixRow{"T6_switched_on_shutdown", switched_on, 0x06, ready_to_switch_on},
        MatrixRow{"switched_on_keeps_on_switch_on", switched_on, 0x07, switched_on},
        MatrixRow{"T4_switched_on_enable_operation", switched_on, 0x0F, operation_enabled},
        MatrixRow{"T9_operation_enabled_disable_voltage", operation_enabled, 0x05,
                  switch_on_disabled},
        MatrixRow{"T11_operation_enabled_quick_stop", operation_enabled, 0x02, quick_stop_active},
        MatrixRow{"T8_operation_enabled_shutdown", operation_enabled, 0x06, ready_to_switch_on},
        MatrixRow{"operation_enabled_keeps_on_enable_operation", operation_enabled, 0x0F,
                  operation_enabled},
        MatrixRow{"operation_enabled_ignores_fault_reset", operation_enabled, 0x80,
                  operation_enabled},
        MatrixRow{"T12_quick_stop_active_disable_voltage", quick_stop_active, 0x00,
                  switch_on_disabled},
        MatrixRow{"quick_stop_active_keeps_on_quick_stop", quick_stop_active, 0x02,
                  quick_stop_active},
        MatrixRow{"quick_stop_active_ignores_shutdown", quick_stop_active, 0x06, quick_stop_active},
        MatrixRow{"quick_stop_active_ignores_switch_on", quick_stop_active, 0x07,
                  quick_stop_active},
        MatrixRow{"quick_stop_active_ignores_enable_operation_with_605Ah_2", quick_stop_active,
                  0x0F, quick_stop_active},
        MatrixRow{"fault_reaction_active_ignores_disable_voltage", fault_reaction_active, 0x00,
                  fault_reaction_active},
        MatrixRow{"fault_reaction_active_ignores_shutdown", fault_reaction_active, 0x06,
                  fault_reaction_active},
        MatrixRow{"fault_reaction_active_ignores_enable_operation", fault_reaction_active, 0x0F,
                  fault_reaction_active},
        MatrixRow{"fault_reaction_active_ignores_fault_reset", fault_reaction_active, 0x80,
                  fault_reaction_active},
        MatrixRow{"fault_ignores_disable_voltage", fault, 0x00, fault},
        MatrixRow{"fault_ignores_quick_stop", fault, 0x02, fault},
        MatrixRow{"fault_ignores_shutdown", fault, 0x06, fault},
        MatrixRow{"fault_ignores_switch_on", fault, 0x07, fault},
        MatrixRow{"fault_ignores_enable_operation", fault, 0x0F, fault},
        MatrixRow{"T15_fault_reset", fault, 0x86, switch_on_disabled}),
    name_of);

TEST(ReactionMatrix, T5DisableOperationAtRestIsDoneWithinTwoTicks) {
  AxisUnderTest axis;
  axis.enable();
  axis.controlword(0x0007);
  EXPECT_NE(axis.step_until_status(0x006F, 0x0023, 2), 0U);
  EXPECT_EQ(axis.statusword(), 0x0233) << "the manual's 563";
}

TEST(ReactionMatrix, T16EnableOperationReEnablesWhere605AhStays) {
  for (std::int64_t option = 0; option <= 8; ++option) {
    AxisUnderTest axis;
    axis.write("quick_stop_option_code", option);
    drive_to(axis, quick_stop_active);
    axis.controlword(0x000F);
    EXPECT_EQ(axis.axis().power_state() == operation_enabled, option >= 5) << "605Ah = " << option;
  }
}

// ---- every word x previous bit 7 x {nothing, fault, master silent, DC link lost}
// -------------------

enum class Event { nothing, fault, master_silent, dc_link_lost };

constexpr std::size_t kBankAxes = 256;

/// Powers an axis of the bank into `state`, bit 7 of the controlword as asked for.
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
      for (std::size_t axis = 0; axis < kBankAxes; ++axis) {
        bank_.power_cycle(axis);
      }
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
    for (int i = 0; i < ticks; ++i) {
      bank_.step();
    }
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
        command(0x80);  // before the fault, so that it is no edge in Fault
      }
      write("test_over_current", 1);
      step(1);
      write("test_over_current", 0);
      step(state == fault ? 100 : 0);
    }
  }

  AxisBank bank_;
};

/// What one tick makes of state, word and event, by the tables above.
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
  if (state == not_ready_to_switch_on) {
    state = switch_on_disabled;
  }
  const bool faulty = state == fault || state == fault_reaction_active;
  if (event == Event::fault && !faulty) {
    return fault_reaction_active;
  }
  if (event == Event::dc_link_lost) {
    if (state == operation_enabled || state == quick_stop_active) {
      return fault_reaction_active;
    }
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

class EveryWord : public testing::TestWithParam<PowerState> {};

TEST_P(EveryWord, DoesWhatTheTablesSayWhateverElseHappensInTheTick) {
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

INSTANTIATE_TEST_SUITE_P(PowerStateMachine, EveryWord,
                         testing::Values(not_ready_to_switch_on, switch_on_disabled,
                                         ready_to_switch_on, switched_on, operation_enabled,
                                         quick_stop_active, fault_reaction_active, fault),
                         name_of_state);

// ---- random walks
// ----------------------------------------------------------------------------------

/// Transitions of CiA 402 that a tick may show, chains within one tick included: enabled and, by
/// 6007h = 3, quickly stopped.
bool legal_step(PowerState from, PowerState to) {
  if (from == to || to == fault_reaction_active) {
    return from != fault || to == fault;  // Fault is left by a reset only
  }
  const bool by_enabling = to == operation_enabled || to == quick_stop_active;
  switch (from) {
    case not_ready_to_switch_on:
      return to == switch_on_disabled;
    case switch_on_disabled:
      return to == ready_to_switch_on || by_enabling;
    case ready_to_switch_on:
      return to == switch_on_disabled || to == switched_on || by_enabling;
    case switched_on:
      return to == switch_on_disabled || to == ready_to_switch_on || by_enabling;
    case operation_enabled:
      return to != not_ready_to_switch_on && to != fault;
    case quick_stop_active:
      return to == switch_on_disabled || to == operation_enabled;
    case fault_reaction_active:
      return to == fault;
    case fault:
      return to == switch_on_disabled;
  }
  return false;
}

TEST(PowerStateMachine, RandomWalksWithEveryOptionCodeTakeLegalTransitionsAndShowOneState) {
  test::Random random(20240611);
  AxisUnderTest axis;
  const std::array<std::uint16_t, 14> words{0x00, 0x02, 0x05, 0x06, 0x07,   0x0F, 0x1F,
                                            0x3F, 0x7F, 0x80, 0x8F, 0x010F, 0x86, 0x011F};
  const std::uint64_t ticks = test::case_count(100'000, 1'000'000);
  PowerState before = axis.state();
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    if (random.one_in(40)) {
      axis.write("quick_stop_option_code", static_cast<std::int64_t>(random.below(9)));
      axis.write("shutdown_option_code", static_cast<std::int64_t>(random.below(2)));
      axis.write("disable_operation_option_code", static_cast<std::int64_t>(random.below(2)));
      axis.write("halt_option_code", 1 + static_cast<std::int64_t>(random.below(4)));
      axis.write("fault_reaction_option_code", static_cast<std::int64_t>(random.below(5)));
      axis.write("abort_connection_option_code", static_cast<std::int64_t>(random.below(4)));
      axis.write("op_mode_cmd", random.one_in(4) ? 0 : 1);
      axis.write("position_user_target_value",
                 static_cast<std::int64_t>(random.below(200'000)) - 100'000);
    }
    const bool one_word = random.one_in(8);
    const std::uint16_t word = words[random.below(words.size())];
    if (one_word) {
      axis.controlword(word);
    }
    if (random.one_in(300)) {
      axis.axis().report_connection_loss();
    }
    for (const char* const cause : {"test_over_current", "test_over_temperature",
                                    "test_encoder_failure", "test_dc_link_loss"}) {
      if (random.one_in(axis.read(cause) != 0 ? 20 : 1000)) {
        axis.write(cause, axis.read(cause) != 0 ? 0 : 1);
      }
    }
    axis.step();

    const std::uint16_t status = axis.statusword();
    const PowerState now = axis.state();
    ASSERT_TRUE(legal_step(before, now))
        << "tick " << tick << ": " << to_string(before) << " -> " << to_string(now);
    ASSERT_EQ(now, axis.axis().power_state());
    ASSERT_EQ(status & 0x6FU, statusword_of(now));
    ASSERT_EQ(status & 0xC100U, 0U) << "bits 8, 14 and 15 are reserved";
    ASSERT_NE(status & Statusword::kRemote, 0);
    const bool may_reach = now == operation_enabled || now == quick_stop_active;
    ASSERT_TRUE(may_reach || (status & Statusword::kTargetReached) == 0) << std::hex << status;
    ASSERT_TRUE(now == operation_enabled || !axis.acknowledged()) << std::hex << status;
    const bool may_have_power =
        now == operation_enabled || now == quick_stop_active || now == fault_reaction_active;
    ASSERT_TRUE(may_have_power || axis.status().motor_op_status == 0);
    ASSERT_TRUE(axis.status().motor_op_status == 1 || axis.status().current_actual_value == 0);
    ASSERT_TRUE(axis.status().motor_op_status == 1 || axis.demand() == axis.actual());
    before = now;
  }
}

}  // namespace
}  // namespace vdrive
