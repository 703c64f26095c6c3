// SPDX-License-Identifier: Apache-2.0
// Every cell of the table in docs/explanation/decisions.md: the ramp with which an axis stops in
// each mode, for each option of 605Ah to 605Eh and at a limit switch, and bits 10, 12 and 13 during
// the stop.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using enum PowerState;

// Ramps of the stops [UU/s per tick].
constexpr std::int32_t kBy6084h = 50;
constexpr std::int32_t kBy609Ah = 80;
constexpr std::int32_t kBy6085h = 100;
constexpr std::int32_t kBy60C6h = 200;
// 6049h and 604Ah in rpm per second: 1125 x 4096 / 60 = 76800 UU/s²,
// 1800 x 4096 / 60 = 122880 UU/s².
constexpr std::int64_t kRpmOf6049h = 1'125;
constexpr std::int64_t kRpmOf604Ah = 1'800;
constexpr std::int32_t kBy6049h = 77;
constexpr std::int32_t kBy604Ah = 123;

/// No stop: the motion goes on.
constexpr std::int32_t kNoStop = 0;
/// The torque is reduced with 6087h; no velocity is commanded.
constexpr std::int32_t kTorqueBack = -1;

/// Bits 10 and 12.
constexpr std::uint16_t kBit10 = 0x0400;
constexpr std::uint16_t kBits12And10 = 0x1400;
constexpr std::uint16_t kBitOf12 = 0x1000;
constexpr std::uint16_t kModeBitsOf6041h = 0x3400;

/// A mode of the table.
struct StopRow {
  std::int64_t mode;
  const char* name;
  const char* object;   // written in each tick; none = nullptr
  std::int32_t normal;  // ramp of option 1
  bool obeys_halt;
  std::uint16_t moving_bits;  // bits 10, 12 and 13 in motion
  std::uint16_t halted_bits;  // at rest under halt, 605Dh = 2
  std::uint16_t word = 0x000F;
  std::int32_t quick = kBy6085h;  // ramp of option 2
  std::int32_t at_switch = kBy6085h;
};

constexpr std::array<StopRow, 9> kStopRows{{
    {1, "profile_position", nullptr, kBy6084h, true, 0, kBit10},
    {2, "velocity", nullptr, kBy6049h, true, kBit10, kBit10, 0x007F, kBy604Ah, kBy604Ah},
    {3, "profile_velocity", nullptr, kBy6084h, true, kBit10, kBits12And10},
    {4, "profile_torque", nullptr, kTorqueBack, true, 0, kBit10},
    {6, "homing", nullptr, kBy609Ah, true, 0, kBit10, 0x000F, kBy6085h, kBy609Ah},
    {7, "interpolated_position", "interpolation_data_record", kBy6084h, true, kBitOf12, kBit10,
     0x001F},
    {8, "cyclic_position", "position_user_target_value", kBy6084h, false, kBitOf12, kBitOf12},
    {9, "cyclic_velocity", "target_velocity", kBy6084h, true, kBitOf12, 0},
    {10, "cyclic_torque", "target_torque", kTorqueBack, true, 0, 0},
}};

/// @return the ramp of a mode change; there, reducing the torque does not count as a stop.
std::int32_t ramp_of_change(const StopRow& row) {
  return row.normal == kTorqueBack ? kBy6084h : row.normal;
}

/// An axis that moves at about 30000 UU/s in the mode of its row.
class MovingAxis {
 public:
  explicit MovingAxis(const StopRow& row) : row_(row) {
    for (const auto& [object, value] : std::array<std::pair<const char*, std::int64_t>, 17>{
             {{"following_error_window", 0xFFFFFFFF},
              {"app_speed_limit", 30'000},
              {"profile_velocity", 30'000},
              {"profile_acc", 1'000'000},
              {"profile_dec", 1'000 * kBy6084h},
              {"homing_acceleration", 1'000 * kBy609Ah},
              {"quick_stop_deceleration", 1'000 * kBy6085h},
              {"app_dec_limit", 1'000 * kBy60C6h},
              {"torque_slope", 8'000},
              {"homing_method", 18},
              {"homing_speed_search", 30'000},
              {"homing_speed_creep", 1'000},
              {"target_velocity", 30'000},
              {"vl_target_velocity", 439},  // rpm: 29969 UU/s
              {"vl_deceleration_delta_speed", kRpmOf6049h},
              {"vl_quick_stop_delta_speed", kRpmOf604Ah},
              {"target_torque", 1'000}}}) {
      axis_.write(object, value);
    }
    axis_.write("op_mode_cmd", row.mode);
    axis_.command(row.word);
    if (row.mode == 1) axis_.write("position_user_target_value", 10'000'000);
    if (row.mode == 1 || row.mode == 6) axis_.command(0x001F);
    axis_.command(row.word);
    run(1'000);
  }

  AxisUnderTest& axis() { return axis_; }

  /// Runs ticks with the stream of the mode.
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      if (row_.object != nullptr) axis_.write(row_.object, next_set_point());
      axis_.step();
    }
  }

  /// @return the decrease of |606Bh| per tick, from the second tick of a stop on.
  std::int32_t ramp() {
    run(2);
    const std::int32_t before = axis_.demand_velocity();
    run(100);
    return (std::abs(before) - std::abs(axis_.demand_velocity())) / 100;
  }

  /// Checks the stop that has been commanded.
  void expect_stop(std::int32_t expected) {
    if (expected == kTorqueBack) {
      // The torque falls from what friction takes at the speed limit; 606Bh is 0 if no velocity is
      // commanded.
      run(10);
      EXPECT_EQ(axis_.status().torque_demand, 0);
      EXPECT_EQ(axis_.demand_velocity(), 0);
    } else {
      EXPECT_NEAR(ramp(), expected, 1);
    }
  }

  /// Checks that the axis has lost its power in `state`, but not its speed. In a tick friction
  /// takes (0.05 N.m + 2e-4 N.m.s/rad x 46 rad/s) / 6e-4 kg.m2 = 99 rad/s², which is 64 UU/s.
  void expect_coasting(PowerState state) {
    EXPECT_EQ(axis_.state(), state);
    EXPECT_EQ(axis_.status().motor_op_status, 0);
    EXPECT_EQ(axis_.status().current_actual_value, 0);
    EXPECT_EQ(axis_.demand_velocity(), 0);
    EXPECT_GT(axis_.velocity(), 29'500);
  }

 private:
  std::int64_t next_set_point() {
    if (row_.mode == 9) return 30'000;
    if (row_.mode == 10) return 1'000;
    position_ += 30;
    return position_;
  }

  StopRow row_;
  AxisUnderTest axis_;
  std::int64_t position_ = 0;
};

/// @return the ramp of an option 1 to 4 of the three option codes.
std::int32_t ramp_of_option(const StopRow& row, std::int64_t option) {
  if (option == 1) return row.normal;
  return option == 2 ? row.quick : kBy60C6h;
}

class StopOfMode : public testing::TestWithParam<StopRow> {};

TEST_P(StopOfMode, AQuickStopHasTheRampOf605Ah) {
  const StopRow& row = GetParam();
  for (std::int64_t option = 1; option <= 8; ++option) {
    SCOPED_TRACE(option);
    MovingAxis moving(row);
    moving.axis().write("quick_stop_option_code", option);
    moving.axis().controlword(0x0002);
    moving.expect_stop(ramp_of_option(row, option > 4 ? option - 4 : option));
    EXPECT_EQ(moving.axis().state(), quick_stop_active);
    moving.run(2'000);
    EXPECT_EQ(moving.axis().statusword(), option > 4 ? 0x0617 : 0x0250);
  }
}

TEST_P(StopOfMode, AFaultHasTheRampOf605Eh) {
  const StopRow& row = GetParam();
  for (std::int64_t option = 1; option <= 4; ++option) {
    SCOPED_TRACE(option);
    MovingAxis moving(row);
    moving.axis().write("fault_reaction_option_code", option);
    moving.axis().write("test_over_temperature", 1);
    moving.expect_stop(ramp_of_option(row, option));
    EXPECT_EQ(moving.axis().statusword() & kModeBitsOf6041h, 0);
    moving.run(2'000);
    EXPECT_EQ(moving.axis().statusword(), 0x0218);
    EXPECT_EQ(moving.axis().status().motor_op_status, 0);
    moving.axis().write("test_over_temperature", 0);
    EXPECT_EQ(moving.axis().command(0x0080), 0x0250);
  }
}

TEST_P(StopOfMode, AHaltHasTheRampOf605DhOrNone) {
  const StopRow& row = GetParam();
  for (std::int64_t option = 1; option <= 4; ++option) {
    SCOPED_TRACE(option);
    MovingAxis moving(row);
    moving.axis().write("halt_option_code", option);
    moving.axis().controlword(static_cast<std::uint16_t>(row.word | 0x0100U));
    moving.expect_stop(row.obeys_halt ? ramp_of_option(row, option) : kNoStop);
    EXPECT_EQ(moving.axis().state(), operation_enabled);
  }
}

TEST_P(StopOfMode, DisableOperationHasTheNormalRamp) {
  const StopRow& row = GetParam();
  MovingAxis moving(row);
  moving.axis().controlword(0x0007);
  moving.expect_stop(row.normal);
  EXPECT_EQ(moving.axis().state(), operation_enabled);
  moving.run(2'000);
  EXPECT_EQ(moving.axis().statusword(), 0x0233);
}

TEST_P(StopOfMode, ShutdownHasTheRampOf605BhOrNone) {
  const StopRow& row = GetParam();
  MovingAxis moving(row);
  moving.axis().write("shutdown_option_code", 1);
  moving.axis().controlword(0x0006);
  moving.expect_stop(row.normal);
  EXPECT_EQ(moving.axis().state(), operation_enabled);
  moving.run(2'000);
  EXPECT_EQ(moving.axis().statusword(), 0x0231);
  MovingAxis coasting(row);
  coasting.axis().write("shutdown_option_code", 0);
  coasting.axis().controlword(0x0006);
  coasting.run(1);
  coasting.expect_coasting(ready_to_switch_on);
}

TEST_P(StopOfMode, DisableOperationHasNoRampWith605ChAt0) {
  MovingAxis coasting(GetParam());
  coasting.axis().write("disable_operation_option_code", 0);
  coasting.axis().controlword(0x0007);
  coasting.run(1);
  coasting.expect_coasting(switched_on);
}

// The state of a stop is shown for one tick even if there is nothing to wait for.
TEST_P(StopOfMode, AQuickStopHasNoRampWith605AhAt0) {
  MovingAxis coasting(GetParam());
  coasting.axis().write("quick_stop_option_code", 0);
  coasting.axis().controlword(0x0002);
  coasting.run(1);
  coasting.expect_coasting(quick_stop_active);
  coasting.run(1);
  coasting.expect_coasting(switch_on_disabled);
}

TEST_P(StopOfMode, AFaultHasNoRampWith605EhAt0) {
  MovingAxis coasting(GetParam());
  coasting.axis().write("fault_reaction_option_code", 0);
  coasting.axis().write("test_over_temperature", 1);
  coasting.run(1);
  coasting.expect_coasting(fault_reaction_active);
  coasting.run(1);
  coasting.expect_coasting(fault);
}

TEST_P(StopOfMode, ALimitSwitchHasTheRampOfItsModeAndNoBitOfAMotion) {
  const StopRow& row = GetParam();
  MovingAxis moving(row);
  moving.axis().write("test_positive_limit_input", 1);
  moving.expect_stop(row.at_switch);
  moving.run(100);
  EXPECT_EQ(moving.axis().statusword() & kModeBitsOf6041h, 0);
}

TEST_P(StopOfMode, AChangeOfTheModeHasTheRampOfTheOldOneUnderPositionControl) {
  const StopRow& row = GetParam();
  for (const std::int64_t mode : {0, 1, 2, 3, 4, 6, 7, 8, 9, 10}) {
    if (mode == row.mode) continue;
    SCOPED_TRACE(mode);
    MovingAxis moving(row);
    moving.axis().write("op_mode_cmd", mode);
    moving.expect_stop(ramp_of_change(row));
    EXPECT_EQ(moving.axis().read("op_mode_actual"), row.mode);
    moving.run(1'000);
    EXPECT_EQ(moving.axis().read("op_mode_actual"), mode);
    EXPECT_EQ(moving.axis().state(), operation_enabled);
  }
}

TEST_P(StopOfMode, Bits10And12And13AreThoseOfItsMotion) {
  const StopRow& row = GetParam();
  MovingAxis moving(row);
  EXPECT_EQ(moving.axis().statusword() & kModeBitsOf6041h, row.moving_bits);
}

TEST_P(StopOfMode, Bits10And12And13AreThoseOfItsHalt) {
  const StopRow& row = GetParam();
  MovingAxis moving(row);
  moving.axis().write("halt_option_code", 2);
  moving.axis().controlword(static_cast<std::uint16_t>(row.word | 0x0100U));
  moving.run(1'000);
  EXPECT_EQ(moving.axis().statusword() & kModeBitsOf6041h, row.halted_bits);
}

TEST_P(StopOfMode, Bit10IsStandstillInAQuickStopThatStays) {
  MovingAxis moving(GetParam());
  moving.axis().write("quick_stop_option_code", 6);
  moving.axis().controlword(0x0002);
  moving.run(20);
  EXPECT_EQ(moving.axis().statusword() & kModeBitsOf6041h, 0);
  moving.run(1'000);
  EXPECT_EQ(moving.axis().statusword(), 0x0617);
}

std::string name_of_stop_row(const testing::TestParamInfo<StopRow>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Modes, StopOfMode, testing::ValuesIn(kStopRows), name_of_stop_row);

}  // namespace
}  // namespace vdrive
