// SPDX-License-Identifier: Apache-2.0
// The effect of a write to each writable object, and when it takes place: immediately, with the
// next set-point, or with the next transition 4. One row per object; the rows together must cover
// all writable objects of both tables.
#include "core/support/axis_under_test.hpp"
#include "core/support/csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using test::CsvRow;

/// An object, a value, and a figure that shows the effect.
struct EffectRow {
  const char* object;
  std::int64_t value;
  double without;  // figure without the write
  double with;
  std::function<void(AxisUnderTest&)> prepare;
  std::function<double(AxisUnderTest&)> figure;  // may step
  double tolerance = 0.0;
};

// ---- situations --------------------------------------------------------------------------------

void nothing(AxisUnderTest& /*axis*/) {}

void enabled(AxisUnderTest& axis) {
  axis.enable();
}

/// At 10000 units/s towards a far target, controlword 001Fh.
void moving(AxisUnderTest& axis) {
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.write("profile_velocity", 10'000);
  axis.write("profile_acc", 1'000'000);
  axis.enable();
  axis.write("position_user_target_value", 1'000'000);
  axis.command(0x001F);
  axis.step(200);
}

/// Accelerating on a long ramp.
void speeding_up(AxisUnderTest& axis) {
  axis.write("profile_velocity", 100'000);
  axis.enable();
  axis.write("position_user_target_value", 100'000'000);
  axis.command(0x001F);
  axis.step(2);
}

/// Braking by a halt from 10000 units/s.
void halting(AxisUnderTest& axis) {
  moving(axis);
  axis.command(0x010F);
}

void quick_stopping(AxisUnderTest& axis) {
  moving(axis);
  axis.command(0x0002);
}

/// Pressed by the full motor torque against a blocked load; sign +1 or -1.
void pressing(AxisUnderTest& axis, int sign) {
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.write("test_blocked_load", 1);
  axis.enable();
  axis.write("position_user_target_value", sign * 1'000'000);
  axis.command(0x001F);
  axis.step(2'000);
}

void pressing_forward(AxisUnderTest& axis) {
  pressing(axis, 1);
}

void pressing_backward(AxisUnderTest& axis) {
  pressing(axis, -1);
}

/// An enabled axis whose torque is limited to almost zero; a load pushes it away.
void pushed(AxisUnderTest& axis) {
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.write("positive_torque_limit_relative", 1);
  axis.write("negative_torque_limit_relative", 1);
  axis.enable();
  axis.write("test_load_torque", 500);
  axis.step(20);
}

// ---- figures -----------------------------------------------------------------------------------

/// Change of the demand's speed in the next tick [units/s²].
double ramp(AxisUnderTest& axis) {
  const std::int32_t before = axis.demand_velocity();
  axis.step();
  return std::abs(axis.demand_velocity() - before) * 1'000.0;
}

double state_after(AxisUnderTest& axis, std::uint16_t word) {
  axis.command(word);
  return axis.statusword() & 0x6FU;
}

double fault_code(AxisUnderTest& axis) {
  axis.step(100);
  return static_cast<double>(axis.read("error_code"));
}

double inputs(AxisUnderTest& axis) {
  axis.step();
  return static_cast<double>(axis.read("digital_inputs"));
}

double torque(AxisUnderTest& axis) {
  axis.step(50);
  return axis.status().torque_actual_value;
}

/// Ticks from a set-point of zero length to bit 10.
double ticks_to_reached(AxisUnderTest& axis) {
  axis.command(0x000F);
  axis.command(0x003F);
  return static_cast<double>(1 + axis.step_until_reached(500));
}

// ---- immediately -------------------------------------------------------------------------------

std::vector<EffectRow> stop_rows() {
  constexpr double kNormal = 409'600.0;   // default of 6084h
  constexpr double kQuick = 2'048'000.0;  // default of 6085h
  const auto after_word = [](std::uint16_t word) {
    return [word](AxisUnderTest& axis) {
      return state_after(axis, word);
    };
  };
  const auto lose_master = [](AxisUnderTest& axis) {
    axis.axis().report_connection_loss();
    return static_cast<double>(axis.step() & 0x6FU);
  };
  const auto fault_ramp = [](AxisUnderTest& axis) {
    axis.write("test_over_current", 1);
    return ramp(axis);
  };
  return {
      {"quick_stop_option_code", 1, kQuick, kNormal, quick_stopping, ramp, 1'000.0},
      {"shutdown_option_code", 1, 0x21, 0x27, moving, after_word(0x0006)},
      {"disable_operation_option_code", 0, 0x27, 0x23, moving, after_word(0x0007)},
      {"halt_option_code", 2, kNormal, kQuick, halting, ramp, 1'000.0},
      {"fault_reaction_option_code", 1, kQuick, kNormal, moving, fault_ramp, 1'000.0},
      // 1: Fault reaction active; 3: Quick stop active.
      {"abort_connection_option_code", 3, 0x0F, 0x07, moving, lose_master},
      {"quick_stop_deceleration", 500'000, kQuick, 500'000.0, quick_stopping, ramp, 1'000.0},
  };
}

std::vector<EffectRow> motion_rows() {
  const auto control_state = [](AxisUnderTest& axis) {
    axis.step();
    return static_cast<double>(axis.statusword() & 0x6FU);
  };
  const auto mode = [](AxisUnderTest& axis) {
    axis.step();
    return static_cast<double>(axis.status().op_mode_actual);
  };
  // A halt from constant velocity, in its second tick: J·((2 ms)² - (1 ms)²)/2 over 1 ms.
  constexpr double kTrapezoid = 409'600.0;
  constexpr double kOfDefaultJerk = 6'144.0;  // 4096000 units/s³
  const auto begin_of_halt = [](AxisUnderTest& axis) {
    axis.command(0x010F);
    return ramp(axis);
  };
  const auto moving_with_jerk = [](AxisUnderTest& axis) {
    axis.write("motion_profile_type", 3);
    moving(axis);
  };
  const auto moving_with_second_jerk = [moving_with_jerk](AxisUnderTest& axis) {
    axis.write("profile_jerk_2", 40'960'000);
    moving_with_jerk(axis);
  };
  const auto moving_with_two_jerks = [moving_with_jerk](AxisUnderTest& axis) {
    axis.write("profile_jerk_use", 2);
    moving_with_jerk(axis);
  };
  return {
      {"motion_profile_type", 3, kTrapezoid, kOfDefaultJerk, moving, begin_of_halt, 1'000.0},
      {"profile_jerk_use", 2, kOfDefaultJerk, 61'440.0, moving_with_second_jerk, begin_of_halt,
       1'000.0},
      {"profile_jerk_1", 40'960'000, kOfDefaultJerk, 61'440.0, moving_with_jerk, begin_of_halt,
       1'000.0},
      {"profile_jerk_2", 40'960'000, kOfDefaultJerk, 61'440.0, moving_with_two_jerks, begin_of_halt,
       1'000.0},
      {"ds402_controlword", 0x0006, 0x27, 0x21, enabled, control_state},
      {"op_mode_cmd", 0, 1.0, 0.0, enabled, mode},
      {"profile_acc", 200'000, 409'600.0, 200'000.0, speeding_up, ramp, 1'000.0},
      {"profile_dec", 200'000, 409'600.0, 200'000.0, halting, ramp, 1'000.0},
      {"app_acc_limit", 100'000, 409'600.0, 100'000.0, speeding_up, ramp, 1'000.0},
      {"app_dec_limit", 100'000, 409'600.0, 100'000.0, halting, ramp, 1'000.0},
  };
}

std::vector<EffectRow> window_rows() {
  const auto reached = [](AxisUnderTest& axis) {
    axis.step(30);
    return axis.reached() ? 1.0 : 0.0;
  };
  const auto limit_bits = [](AxisUnderTest& axis) {
    return static_cast<double>(axis.step() & 0x0880U);  // bit 11 at the limit, bit 7 beyond
  };
  const auto at_position_0_with_limits = [](AxisUnderTest& axis) {
    axis.write("app_position_limit_switch", 1);
    axis.step();
  };
  const auto beyond_a_limit = [](AxisUnderTest& axis) {
    axis.write("user_position_upper_limit", -10);
    axis.step();
  };
  return {
      {"position_target_reached_window", 1'000'000, 0.0, 1.0, pushed, reached},
      // Reached in the first tick whose time in the window exceeds 6068h.
      {"position_target_reached_window_time", 50, 21.0, 51.0, enabled, ticks_to_reached, 1.0},
      {"app_position_limit_switch", 1, 0.0, 0x0880, beyond_a_limit, limit_bits},
      {"user_position_lower_limit", 10, 0.0, 0x0880, at_position_0_with_limits, limit_bits},
      {"user_position_upper_limit", -10, 0.0, 0x0880, at_position_0_with_limits, limit_bits},
      {"following_error_window", 2, 0.0, 0x8611, pushed, fault_code},
      {"following_error_time_out", 0, 0.0, 0x8611,
       [](AxisUnderTest& axis) {
         axis.write("following_error_time_out", 0xFFFF);
         pushed(axis);
         axis.write("following_error_window", 2);
       },
       fault_code},
      // A load moves a halted axis: it counts as standing still if its speed is below 606Fh.
      {"velocity_threshold", 0xFFFF, 0x0000, 0x0400,
       [](AxisUnderTest& axis) {
         pushed(axis);
         axis.command(0x010F);
         axis.step(5);
       },
       [](AxisUnderTest& axis) {
         return static_cast<double>(axis.step() & 0x0400U);
       }},
  };
}

std::vector<EffectRow> torque_rows() {
  const auto current = [](AxisUnderTest& axis) {
    axis.step(50);
    return static_cast<double>(axis.status().current_actual_value);
  };
  const auto holding = [](AxisUnderTest& axis) {
    axis.enable();
    axis.write("test_load_torque", -3'000);
    axis.step(3'000);
  };
  return {
      // Pressing against a blocked load, the torque is at its limit [‰ of 6076h].
      {"positive_torque_limit_relative", 200, 3'000.0, 200.0, pressing_forward, torque, 1.0},
      {"negative_torque_limit_relative", 200, -3'000.0, -200.0, pressing_backward, torque, 1.0},
      {"max_torque", 500, 3'000.0, 500.0, pressing_forward, torque, 1.0},
      // Holding 3 N.m, which is 5 A at 0.6 N.m/A, plus or minus the friction of 0.05 N.m.
      {"motor_rated_torque", 6'000, 1'000.0, 500.0, holding, torque, 17.0},
      {"motor_rated_current", 10'000, 1'000.0, 500.0, holding, current, 17.0},
  };
}

std::vector<EffectRow> gear_rows() {
  const auto load_over_motor = [](AxisUnderTest& axis) {
    axis.step(2);  // so that the speeds are those of a whole tick
    return static_cast<double>(axis.velocity()) / axis.status().motor_velocity_actual_value;
  };
  const auto spinning = [](AxisUnderTest& axis) {
    axis.write("test_load_torque", 1'000);
    axis.step(200);
  };
  return {
      {"gear_ratio_numerator", 3, 1.0, 3.0, spinning, load_over_motor, 1.0e-3},
      {"gear_ratio_denominator", 4, 1.0, 0.25, spinning, load_over_motor, 1.0e-3},
  };
}

std::vector<EffectRow> bench_rows() {
  const auto acceleration = [](AxisUnderTest& axis) {
    const std::int32_t start = axis.velocity();
    axis.step(10);
    return (axis.velocity() - start) * 100.0;
  };
  const auto power = [](AxisUnderTest& axis) {
    axis.step();
    return static_cast<double>(axis.status().motor_op_status);
  };
  const auto speed_shown = [](AxisUnderTest& axis) {
    axis.step();
    return axis.velocity() == 0 ? 0.0 : 1.0;
  };
  const auto blocked_speed = [](AxisUnderTest& axis) {
    axis.step(2);
    return axis.velocity() == 0 ? 0.0 : 1.0;
  };
  const auto count_after_fault = [](AxisUnderTest& axis) {
    axis.step();
    return static_cast<double>(axis.read("error_history_count"));
  };
  return {
      // 1 N.m minus 0.05 N.m of friction, on 6e-4 kg.m2; 606Ch lags by half a tick.
      {"test_load_torque", 1'000, 0.0, 0.95 / 6.0e-4 * test::kUnitsPerRadian, nothing, acceleration,
       70'000.0},
      {"test_blocked_load", 1, 1.0, 0.0, moving, blocked_speed},
      {"test_over_current", 1, 0.0, 0x2310, enabled, fault_code},
      {"test_over_temperature", 1, 0.0, 0x4310, enabled, fault_code},
      {"test_encoder_failure", 2, 0.0, 0x7305, enabled, fault_code},
      {"test_dc_link_loss", 1, 0.0, 0x3220, enabled, fault_code},
      {"test_connection_loss", 1, 0.0, 0x8130, enabled, fault_code},
      {"test_power_drop", 1, 1.0, 0.0, enabled, power},
      {"test_frozen_feedback", 1, 1.0, 0.0, moving, speed_shown},
      {"test_positive_limit_input", 1, 0.0, 2.0, nothing, inputs},
      {"test_negative_limit_input", 1, 0.0, 1.0, nothing, inputs},
      {"test_home_input", 1, 0.0, 4.0, nothing, inputs},
      // The axis is at 0, on the switch, which is active at and beyond its position.
      {"test_switch_positive_limit", 0, 0.0, 2.0, nothing, inputs},
      {"test_switch_negative_limit", 0, 0.0, 1.0, nothing, inputs},
      {"test_switch_home", -10, 0.0, 4.0,
       [](AxisUnderTest& axis) {
         axis.write("test_switch_home", 10);
         axis.write("test_switch_home_length", 20);
       },
       inputs},
      {"test_switch_home_length", 20, 0.0, 4.0, nothing, inputs},
      {"error_history_count", 0, 1.0, 0.0,
       [](AxisUnderTest& axis) {
         axis.write("test_over_current", 1);
         axis.step(3);
       },
       count_after_fault},
  };
}

class ImmediateEffect : public testing::TestWithParam<EffectRow> {};

TEST_P(ImmediateEffect, IsVisibleInTheNextTick) {
  const EffectRow& row = GetParam();
  AxisUnderTest axis;
  row.prepare(axis);
  AxisUnderTest changed;
  row.prepare(changed);
  ASSERT_NEAR(row.figure(axis), row.without, row.tolerance);
  changed.write(row.object, row.value);
  EXPECT_NEAR(row.figure(changed), row.with, row.tolerance);
}

std::string name_of_effect(const testing::TestParamInfo<EffectRow>& info) {
  return info.param.object;
}

INSTANTIATE_TEST_SUITE_P(Stops, ImmediateEffect, testing::ValuesIn(stop_rows()), name_of_effect);
INSTANTIATE_TEST_SUITE_P(Motion, ImmediateEffect, testing::ValuesIn(motion_rows()), name_of_effect);
INSTANTIATE_TEST_SUITE_P(Windows, ImmediateEffect, testing::ValuesIn(window_rows()),
                         name_of_effect);
INSTANTIATE_TEST_SUITE_P(Torques, ImmediateEffect, testing::ValuesIn(torque_rows()),
                         name_of_effect);
INSTANTIATE_TEST_SUITE_P(Gear, ImmediateEffect, testing::ValuesIn(gear_rows()), name_of_effect);
INSTANTIATE_TEST_SUITE_P(Bench, ImmediateEffect, testing::ValuesIn(bench_rows()), name_of_effect);

// ---- later -------------------------------------------------------------------------------------

TEST(EffectAtSetPoint, TheTargetPositionWaitsForTheNextEdgeOfBit4) {
  AxisUnderTest axis;
  moving(axis);
  axis.write("position_user_target_value", 5'000);
  axis.step(1'000);
  EXPECT_GT(axis.demand(), 10'000) << "on the way to 1000000";
  axis.command(0x000F);
  axis.command(0x003F);
  axis.step(3'000);
  EXPECT_EQ(axis.demand(), 5'000);
}

TEST(EffectAtSetPoint, TheProfileVelocityWaitsForTheNextEdgeOfBit4) {
  AxisUnderTest axis;
  moving(axis);
  axis.write("profile_velocity", 4'000);
  axis.step(500);
  EXPECT_EQ(axis.demand_velocity(), 10'000);
  axis.command(0x000F);
  axis.command(0x003F);
  axis.step(500);
  EXPECT_EQ(axis.demand_velocity(), 4'000);
}

TEST(EffectAtSetPoint, ThePositioningOptionWaitsForTheNextEdgeOfBit4) {
  // A relative move that is written in motion starts from the target 5000, not from the actual
  // position.
  AxisUnderTest axis;
  axis.write("profile_velocity", 10'000);
  axis.enable();
  axis.write("position_user_target_value", 5'000);
  axis.command(0x001F);
  axis.step(200);
  axis.write("positioning_option_code", 0);
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 10'000);
  axis.write("position_user_target_value", 300);
  axis.command(0x000F);
  axis.command(0x007F);
  axis.step(2'000);
  EXPECT_EQ(axis.demand(), 5'300);
}

struct LaterRow {
  const char* object;
  std::int64_t value;
  std::int32_t speed;  // the speed that it allows
};

class EffectAtEnable : public testing::TestWithParam<LaterRow> {};

TEST_P(EffectAtEnable, WaitsForTheNextTransition4) {
  AxisUnderTest axis;
  moving(axis);
  axis.write(GetParam().object, GetParam().value);
  axis.step(500);
  EXPECT_EQ(axis.demand_velocity(), 10'000);
  axis.command(0x000F);
  axis.command(0x003F);
  axis.step(500);
  EXPECT_EQ(axis.demand_velocity(), 10'000) << "a set-point is not enough";
  axis.command(0x0006);
  axis.command(0x000F);
  axis.command(0x003F);
  axis.step(500);
  EXPECT_EQ(axis.demand_velocity(), GetParam().speed);
}

// 6080h: 100 rpm x 4096/60 = 6826.67 units/s.
const std::vector<LaterRow> kAtEnable{{"app_speed_limit", 5'000, 5'000},
                                      {"motor_max_speed_rpm", 100, 6'827}};

INSTANTIATE_TEST_SUITE_P(Dictionary, EffectAtEnable, testing::ValuesIn(kAtEnable),
                         [](const auto& row) {
                           return std::string(row.param.object);
                         });

// ---- the rows together -------------------------------------------------------------------------

/// Objects of particular modes, and habits of other drives; the tests of the modes and
/// tests/core/habits_test.cpp show their effects.
const std::set<std::string> kOfOtherModes{"velocity_window",
                                          "velocity_window_time",
                                          "velocity_threshold_time",
                                          "target_velocity",
                                          "target_torque",
                                          "torque_slope",
                                          "home_offset",
                                          "homing_method",
                                          "homing_speed_search",
                                          "homing_speed_creep",
                                          "homing_acceleration",
                                          "homing_stop_torque",
                                          "homing_stop_time",
                                          "test_index_pulse_input",
                                          "missing_set_points_extrapolated",
                                          "missing_set_points_until_fault",
                                          "position_offset",
                                          "velocity_offset",
                                          "torque_offset",
                                          "interpolation_sub_mode_select",
                                          "interpolation_data_record",
                                          "interpolation_buffer_size",
                                          "interpolation_buffer_organization",
                                          "interpolation_buffer_record_size",
                                          "interpolation_buffer_clear",
                                          "touch_probe_function",
                                          "touch_probe_source_1",
                                          "touch_probe_source_2",
                                          "interpolation_time_period",
                                          "interpolation_time_index",
                                          "vl_target_velocity",
                                          "vl_velocity_min_amount",
                                          "vl_velocity_max_amount",
                                          "vl_acceleration_delta_speed",
                                          "vl_acceleration_delta_time",
                                          "vl_deceleration_delta_speed",
                                          "vl_deceleration_delta_time",
                                          "vl_quick_stop_delta_speed",
                                          "vl_quick_stop_delta_time",
                                          "vl_set_point_factor_numerator",
                                          "vl_set_point_factor_denominator",
                                          "vl_dimension_factor_numerator",
                                          "vl_dimension_factor_denominator",
                                          "min_position_range_limit",
                                          "max_position_range_limit",
                                          "digital_outputs",
                                          "digital_outputs_mask",
                                          "synchronous_move_duration",
                                          "synchronous_move_acceleration_time",
                                          "synchronous_move_deceleration_time",
                                          "synchronous_move_jerk_time",
                                          "synchronous_move_reference_way",
                                          "habit_acknowledge_at_enabling",
                                          "habit_stream_release_bits",
                                          "habit_short_quick_stop",
                                          "habit_transition_16",
                                          "habit_mode_change_refusal",
                                          "habit_controlword_loop",
                                          "habit_power_on_time",
                                          "habit_mode_display_delay",
                                          "habit_fault_reset_delay",
                                          "habit_stream_target_bit",
                                          "habit_plan_from_rest",
                                          "habit_statusword_bits",
                                          "habit_homing_by_level",
                                          "habit_clear_target_velocity",
                                          "habit_homing_ends_at_halt",
                                          "habit_mode_before_enabling",
                                          "store_all_parameters",
                                          "restore_all_default_parameters"};

TEST(Effects, OfEveryWritableObjectHappenAtTheMomentThatTheTableNames) {
  std::set<std::string> shown(kOfOtherModes);
  for (const auto& rows :
       {stop_rows(), motion_rows(), window_rows(), torque_rows(), gear_rows(), bench_rows()}) {
    for (const EffectRow& row : rows) {
      EXPECT_TRUE(shown.insert(row.object).second) << row.object << " twice";
      EXPECT_EQ(describe(*find_object(row.object)).effective, Effective::immediately) << row.object;
    }
  }
  for (const char* const object :
       {"position_user_target_value", "profile_velocity", "positioning_option_code"}) {
    EXPECT_TRUE(shown.insert(object).second) << object << " twice";
    EXPECT_EQ(describe(*find_object(object)).effective, Effective::at_set_point) << object;
  }
  for (const LaterRow& row : kAtEnable) {
    EXPECT_TRUE(shown.insert(row.object).second) << row.object << " twice";
    EXPECT_EQ(describe(*find_object(row.object)).effective, Effective::at_enable) << row.object;
  }
  std::set<std::string> writable;
  for (const char* const file : {"object-dictionary.csv", "companion-objects.csv"}) {
    for (const CsvRow& row : test::read_csv(VDRIVE_SOURCE_DIR "/tests/data/" + std::string(file))) {
      if (row.at("access") == "RW") writable.insert(row.at("variable_name"));
    }
  }
  for (const std::string& object : writable) {
    EXPECT_TRUE(shown.contains(object))
        << object
        << " can be written: tests/core/dictionary_effect_test.cpp needs a row of it, with a "
        << "figure that the write changes, or its name in kOfOtherModes";
  }
  for (const std::string& object : shown) {
    EXPECT_TRUE(writable.contains(object))
        << object << " of tests/core/dictionary_effect_test.cpp cannot be written";
  }
}

}  // namespace
}  // namespace vdrive
