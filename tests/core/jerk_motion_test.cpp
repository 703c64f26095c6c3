// SPDX-License-Identifier: Apache-2.0
// 6086h, 60A3h and 60A4h: which motions of an axis have limited jerk, and how the jerk changes from
// one plan to the next.
#include "core/support/axis_under_test.hpp"
#include "support/random_cases.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;
using test::Random;
using enum PowerState;

constexpr std::int32_t kNormalTick = 410;  // default of 6084h: 409600 UU/s² for 1 ms
constexpr std::int32_t kQuickTick = 2048;  // default of 6085h: 2048000 UU/s² for 1 ms

/// Sets the profile to limited jerk [UU/s³].
void limit_jerk(AxisUnderTest& axis, std::int64_t jerk) {
  axis.write("motion_profile_type", 3);
  axis.write("profile_jerk_1", jerk);
}

/// Starts a move immediately, even in motion.
void start_move(AxisUnderTest& axis, std::int64_t target) {
  axis.write("position_user_target_value", target);
  axis.controlword(0x002F);
  axis.command(0x003F);
}

/// @return the decrease of 606Bh in the next tick.
std::int32_t lost_in_a_tick(AxisUnderTest& axis) {
  const std::int32_t before = axis.demand_velocity();
  axis.step();
  return before - axis.demand_velocity();
}

/// At 10000 units/s towards a far target, with the default jerk of 4096000 UU/s³.
void run_with_jerk(AxisUnderTest& axis) {
  limit_jerk(axis, 4'096'000);
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.write("profile_velocity", 10'000);
  axis.enable();
  start_move(axis, 1'000'000);
  axis.step(200);  // 0.1 s: twice the root of 10000/4096000
  ASSERT_EQ(axis.demand_velocity(), 10'000);
}

// ---- objects ------------------------------------------------------------------------------------

TEST(LimitedJerk, IsOffByDefault) {
  const AxisUnderTest axis;
  EXPECT_EQ(axis.read("motion_profile_type"), 0);
  EXPECT_EQ(axis.read("profile_jerk_use"), 1);
  EXPECT_EQ(axis.read("profile_jerk_1"), 4'096'000);
  EXPECT_EQ(axis.read("profile_jerk_2"), 4'096'000);
  EXPECT_EQ(axis.read("synchronous_move_jerk_time"), 0);
}

TEST(LimitedJerk, RefusesProfilesAndNumbersOfJerksThatItHasNot) {
  AxisUnderTest axis;
  for (const int value : {-1, 1, 2, 4, 32'767}) {
    EXPECT_EQ(axis.try_write("motion_profile_type", value), AbortCode::value_range_exceeded)
        << value;
  }
  EXPECT_EQ(axis.try_write("motion_profile_type", 32'768), AbortCode::value_too_high);
  for (const int value : {0, 3, 4, 255}) {
    EXPECT_EQ(axis.try_write("profile_jerk_use", value), AbortCode::value_range_exceeded) << value;
  }
  EXPECT_EQ(axis.try_write("profile_jerk_1", 0), AbortCode::value_too_low);
  EXPECT_EQ(axis.try_write("profile_jerk_2", 0), AbortCode::value_too_low);
  EXPECT_EQ(axis.try_write("profile_jerk_1", 4'294'967'295), AbortCode::none);
}

// ---- moves --------------------------------------------------------------------------------------

TEST(LimitedJerk, RoundsBothRampsOfAMove) {
  // 1000 UU/s with 6000 UU/s² and 60000 UU/s³: ramps of 1000/6000 + 6000/60000 = 0.26667 s and
  // 133.33 units, 9.73333 s between them, 10.26667 s in total.
  AxisUnderTest axis;
  limit_jerk(axis, 60'000);
  axis.write("profile_velocity", 1'000);
  axis.write("profile_acc", 6'000);
  axis.write("profile_dec", 6'000);
  axis.enable();
  start_move(axis, 10'000);
  axis.step(99);
  EXPECT_EQ(axis.demand(), 10);  // 60000·0.1³/6
  EXPECT_EQ(axis.demand_velocity(), 300);
  axis.step(900);
  EXPECT_NEAR(axis.demand(), 867, 1);  // 133.33 + 1000·(1 - 0.26667)
  EXPECT_EQ(axis.demand_velocity(), 1'000);
  axis.step(9'167);
  EXPECT_NEAR(axis.demand_velocity(), 298, 1);  // 99.67 ms before the end: 60000·0.09967²/2
  axis.step(99);
  EXPECT_FALSE(axis.reached());
  axis.step();
  EXPECT_EQ(axis.demand(), 10'000);
  EXPECT_EQ(axis.demand_velocity(), 0);
  EXPECT_NE(axis.step_until_reached(200), 0U);
}

TEST(LimitedJerk, HasASecondJerkForTheSpeedThatShrinks) {
  AxisUnderTest axis;
  axis.write("profile_jerk_use", 2);
  axis.write("profile_jerk_2", 40'960'000);
  run_with_jerk(axis);
  axis.command(0x012F);
  // 40960000 UU/s³ over the second tick: 40960000·(4e-6 - 1e-6)/2 = 61 UU/s.
  EXPECT_NEAR(lost_in_a_tick(axis), 61, 1);
}

/// Checks in each tick that the second difference of 606Bh keeps to the limited jerk.
class SmoothAxis {
 public:
  static constexpr std::int32_t kRounding = 3;

  // With 1e8 UU/s³ the change of speed per tick grows by up to 100 UU/s from tick to tick; without
  // limited jerk a ramp of 1e6 UU/s² has 1000 UU/s in its first tick.
  SmoothAxis() {
    limit_jerk(axis_, kFirstJerk);
    axis_.write("profile_jerk_2", kFirstJerk);
    axis_.write("following_error_window", 0xFFFFFFFF);
    axis_.write("profile_velocity", 100'000);
    axis_.write("profile_acc", 1'000'000);
    axis_.write("profile_dec", 1'000'000);
    axis_.enable();
  }

  AxisUnderTest& axis() { return axis_; }

  /// Sets one jerk for each ramp [UU/s³], even in motion.
  void set_jerks(std::int64_t first, std::int64_t second) {
    axis_.write("profile_jerk_use", 2);
    axis_.write("profile_jerk_1", first);
    axis_.write("profile_jerk_2", second);
    // A second difference includes a part of the previous tick.
    old_jerk_ = std::max(jerk_, since_change_ < 2 ? old_jerk_ : 0);
    jerk_ = std::max(first, second);
    since_change_ = 0;
  }

  /// One tick, which must be smooth.
  void step() {
    axis_.step();
    note();
  }

  void step(int ticks) {
    for (int i = 0; i < ticks; ++i) step();
  }

  /// Checks the tick that has just been run.
  void note() {
    const std::int32_t velocity = axis_.demand_velocity();
    const std::int32_t change = velocity - velocity_;
    const std::int64_t jerk = since_change_ < 2 ? std::max(jerk_, old_jerk_) : jerk_;
    EXPECT_LE(std::abs(change - change_), jerk / 1'000'000 + kRounding) << "tick " << axis_.ticks();
    EXPECT_LE(std::abs(change), 1'000 + kRounding) << "tick " << axis_.ticks();
    ++since_change_;
    velocity_ = velocity;
    change_ = change;
  }

 private:
  static constexpr std::int64_t kFirstJerk = 100'000'000;

  AxisUnderTest axis_;
  std::int32_t velocity_ = 0;
  std::int32_t change_ = 0;
  std::int64_t jerk_ = kFirstJerk;
  std::int64_t old_jerk_ = 0;
  int since_change_ = 2;
};

/// A test with random changes in motion, and its seed.
class LimitedJerkInMotion : public testing::TestWithParam<std::uint64_t> {
 protected:
  static constexpr int kChanges = 100;

  SmoothAxis& smooth() { return smooth_; }

  AxisUnderTest& axis() { return smooth_.axis(); }

  Random& random() { return random_; }

  /// @return a value from -most to most.
  std::int64_t any_up_to(std::uint64_t most) {
    return static_cast<std::int64_t>(random_.below(2 * most + 1)) - static_cast<std::int64_t>(most);
  }

  void change_a_ramp() {
    axis().write(random_.one_in(2) ? "profile_acc" : "profile_dec",
                 static_cast<std::int64_t>(100'000 + random_.below(900'001)));
  }

  /// Changes of 10 to 1000 UU/s per tick.
  void change_the_jerks() {
    const auto any = [this] {
      return static_cast<std::int64_t>(10'000'000 +
                                       random_.below(random_.one_in(2) ? 90'000'001 : 990'000'001));
    };
    const std::int64_t first = any();
    smooth_.set_jerks(first, random_.one_in(2) ? first : any());
  }

  void new_target(std::int64_t target) {
    axis().write("position_user_target_value", target);
    axis().controlword(0x002F);
    smooth_.step();
    axis().controlword(0x003F);
  }

  /// A move to the other side, and a halt while it turns round.
  void halt_in_a_reversal() {
    const std::int64_t way = axis().demand_velocity() > 0 ? -200'000 : 200'000;
    new_target(axis().demand() + way);
    smooth_.step(1 + static_cast<int>(random_.below(300)));
    axis().controlword(0x012F);
  }

  void run_on() { smooth_.step(1 + static_cast<int>(random_.below(150))); }

 private:
  SmoothAxis smooth_;
  Random random_{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Seeds, LimitedJerkInMotion, testing::Range<std::uint64_t>(1, 21));

TEST_P(LimitedJerkInMotion, StaysLimitedFromOnePlanToTheNext) {
  for (int change = 0; change < kChanges && !HasFailure(); ++change) {
    SCOPED_TRACE("change " + std::to_string(change));
    switch (random().below(6)) {
      case 0:
        change_a_ramp();
        break;
      case 1:
        change_the_jerks();
        break;
      case 2:
        axis().controlword(0x010F);
        break;
      case 3:
        halt_in_a_reversal();
        break;
      default:
        axis().write("profile_velocity", static_cast<std::int64_t>(1'000 + random().below(99'001)));
        new_target(any_up_to(100'000));
        break;
    }
    run_on();
  }
  if (HasFailure()) return;
  smooth().set_jerks(100'000'000, 100'000'000);
  axis().write("profile_velocity", 100'000);
  new_target(4'711);
  smooth().step(10'000);
  EXPECT_EQ(axis().demand(), 4'711);
  EXPECT_EQ(axis().demand_velocity(), 0);
}

TEST_P(LimitedJerkInMotion, StaysLimitedInProfileVelocityMode) {
  axis().write("op_mode_cmd", 3);
  smooth().step();
  for (int change = 0; change < kChanges && !HasFailure(); ++change) {
    SCOPED_TRACE("change " + std::to_string(change));
    switch (random().below(5)) {
      case 0:
        change_a_ramp();
        break;
      case 1:
        change_the_jerks();
        break;
      case 2:
        axis().controlword(random().one_in(2) ? 0x010F : 0x000F);
        break;
      default:
        axis().write("target_velocity", any_up_to(100'000));
        break;
    }
    run_on();
  }
  if (HasFailure()) return;
  smooth().set_jerks(100'000'000, 100'000'000);
  axis().write("target_velocity", 4'711);
  axis().controlword(0x000F);
  smooth().step(4'000);
  EXPECT_EQ(axis().demand_velocity(), 4'711);
}

TEST_P(LimitedJerkInMotion, BeginsAndEndsWithoutAJumpOfTheVelocity) {
  // A trapezoid changes the acceleration abruptly, but no plan changes the velocity by more than
  // its ramp allows in a tick.
  std::int32_t before = 0;
  for (int change = 0; change < kChanges && !HasFailure(); ++change) {
    SCOPED_TRACE("change " + std::to_string(change));
    if (random().one_in(2)) {
      axis().write("motion_profile_type", random().one_in(2) ? 3 : 0);
    } else {
      axis().write("position_user_target_value", any_up_to(100'000));
      axis().controlword(0x002F);
      axis().step();
      EXPECT_LE(std::abs(axis().demand_velocity() - before), 1'000 + SmoothAxis::kRounding);
      before = axis().demand_velocity();
      axis().controlword(0x003F);
    }
    for (std::uint64_t left = 1 + random().below(150); left > 0; --left) {
      axis().step();
      EXPECT_LE(std::abs(axis().demand_velocity() - before), 1'000 + SmoothAxis::kRounding)
          << "tick " << axis().ticks();
      before = axis().demand_velocity();
    }
  }
}

TEST(LimitedJerk, BeginsWithTheAccelerationThatATrapezoidHas) {
  AxisUnderTest axis;
  axis.write("profile_velocity", 100'000);
  axis.enable();
  start_move(axis, 10'000'000);
  axis.step(50);
  limit_jerk(axis, 4'096'000);
  EXPECT_NEAR(lost_in_a_tick(axis), -kNormalTick, 1) << "the ramp goes on";
  axis.write("motion_profile_type", 0);
  EXPECT_NEAR(lost_in_a_tick(axis), -kNormalTick, 1);
}

// ---- stops --------------------------------------------------------------------------------------

TEST(LimitedJerk, RoundsAHaltByTheProfileRampOnly) {
  for (const int option : {1, 2, 3}) {
    AxisUnderTest axis;
    axis.write("halt_option_code", option);
    run_with_jerk(axis);
    axis.controlword(0x012F);
    const std::int32_t lost = lost_in_a_tick(axis);
    if (option == 1) {
      EXPECT_EQ(lost, 2) << "4096000 UU/s³ for 1 ms";
    } else {
      EXPECT_GE(lost, kQuickTick) << option;
    }
  }
}

TEST(LimitedJerk, RoundsTheRampOfDisableOperation) {
  AxisUnderTest axis;
  axis.write("disable_operation_option_code", 1);
  run_with_jerk(axis);
  axis.controlword(0x0007);
  EXPECT_EQ(lost_in_a_tick(axis), 2);
  EXPECT_NE(axis.step_until_state(switched_on, 2'000), 0U);
}

TEST(LimitedJerk, RoundsTheRampOfAModeChange) {
  AxisUnderTest axis;
  run_with_jerk(axis);
  axis.write("op_mode_cmd", 3);
  EXPECT_EQ(lost_in_a_tick(axis), 2);
}

TEST(LimitedJerk, IsNotInAQuickStop) {
  for (const int option : {1, 2, 5, 6}) {
    AxisUnderTest axis;
    axis.write("quick_stop_option_code", option);
    run_with_jerk(axis);
    axis.controlword(0x0002);
    EXPECT_NEAR(lost_in_a_tick(axis), option % 4 == 1 ? kNormalTick : kQuickTick, 1) << option;
  }
}

TEST(LimitedJerk, IsNotInAFaultReaction) {
  for (const int option : {1, 2}) {
    AxisUnderTest axis;
    axis.write("fault_reaction_option_code", option);
    run_with_jerk(axis);
    axis.write("test_over_current", 1);
    EXPECT_NEAR(lost_in_a_tick(axis), option == 1 ? kNormalTick : kQuickTick, 1) << option;
  }
}

TEST(LimitedJerk, IsNotInTheStopAtALimitSwitch) {
  AxisUnderTest axis;
  run_with_jerk(axis);
  axis.write("test_positive_limit_input", 1);
  EXPECT_NEAR(lost_in_a_tick(axis), kQuickTick, 1);
}

// Reducing 2048000 UU/s² to 0 with a jerk of 4096000 UU/s³ would take 0.5 s and change the speed by
// 512000 UU/s: the axis would move backwards, faster than any limit.
TEST(LimitedJerk, KeepsOnlyTheDecelerationItCanEndBeforeStandstill) {
  AxisUnderTest axis;
  axis.write("quick_stop_option_code", 6);
  run_with_jerk(axis);
  axis.controlword(0x0002);
  axis.step(2);
  ASSERT_NEAR(axis.demand_velocity(), 10'000 - 2 * kQuickTick, 1);  // 5904
  axis.controlword(0x000F);                                         // transition 16
  // The root of 2·4096000·5904 is 219920 UU/s², which can end in 54 ms; its average over the first
  // tick is 217872.
  EXPECT_NEAR(lost_in_a_tick(axis), 218, 1);
  for (int tick = 0; tick < 60; ++tick) {
    axis.step();
    EXPECT_GE(axis.demand_velocity(), 0) << tick;
  }
  EXPECT_EQ(axis.demand_velocity(), 0);
}

TEST(LimitedJerk, KeepsItsSpeedAfterAStopThatALimitSwitchReleases) {
  AxisUnderTest axis;
  run_with_jerk(axis);
  start_move(axis, 0);  // on the near side of the switch
  axis.write("test_positive_limit_input", 1);
  axis.step(3);
  ASSERT_NEAR(axis.demand_velocity(), 9'998 - 3 * kQuickTick, 1);  // 3854
  axis.write("test_positive_limit_input", 0);
  // The root of 2·4096000·3854 is 177685 UU/s²; the move back adds to it: 178 + 2 UU/s.
  EXPECT_NEAR(lost_in_a_tick(axis), 180, 1);
  for (int tick = 0; tick < 1'000; ++tick) {
    axis.step();
    ASSERT_LE(std::abs(axis.demand_velocity()), 10'000) << tick;
  }
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_EQ(axis.demand_velocity(), 0);
}

TEST(LimitedJerk, MakesAnAxisThatSpeedsUpFasterBeforeItHalts) {
  // After 0.05 s the axis has 4096000·0.05 = 204800 UU/s² and 5120 UU/s. The acceleration ends
  // 0.05 s later, at 10240 UU/s.
  AxisUnderTest axis;
  limit_jerk(axis, 4'096'000);
  axis.write("following_error_window", 0xFFFFFFFF);
  axis.write("profile_velocity", 100'000);
  axis.enable();
  start_move(axis, 1'000'000);
  axis.step(49);
  ASSERT_EQ(axis.demand_velocity(), 5'120);
  axis.controlword(0x012F);
  axis.step(50);
  EXPECT_EQ(axis.demand_velocity(), 10'240);
  axis.step(1'000);
  EXPECT_EQ(axis.demand_velocity(), 0);
  EXPECT_TRUE(axis.reached()) << "it stands";
}

// ---- other modes --------------------------------------------------------------------------------

TEST(LimitedJerk, RoundsTheRampsOfProfileVelocity) {
  AxisUnderTest axis;
  limit_jerk(axis, 4'096'000);
  axis.write("op_mode_cmd", 3);
  axis.command(0x000F);
  axis.write("target_velocity", 10'000);
  axis.step(20);
  EXPECT_NEAR(axis.demand_velocity(), 819, 1);  // 4096000·0.02²/2
  axis.step(100);
  EXPECT_EQ(axis.demand_velocity(), 10'000);  // twice the root of 10000/4096000 = 0.0988 s
  axis.write("target_velocity", -10'000);
  axis.step(20);
  EXPECT_NEAR(axis.demand_velocity(), 9'181, 1);
  axis.step(300);
  EXPECT_EQ(axis.demand_velocity(), -10'000);
  axis.controlword(0x010F);
  EXPECT_EQ(lost_in_a_tick(axis), -2);
  axis.step(300);
  EXPECT_EQ(axis.demand_velocity(), 0);
}

TEST(LimitedJerk, IsNotInAHaltOfProfileVelocityByAnotherRamp) {
  AxisUnderTest axis;
  limit_jerk(axis, 4'096'000);
  axis.write("halt_option_code", 2);
  axis.write("op_mode_cmd", 3);
  axis.command(0x000F);
  axis.write("target_velocity", 10'000);
  axis.step(200);
  ASSERT_EQ(axis.demand_velocity(), 10'000);
  axis.controlword(0x010F);
  EXPECT_NEAR(lost_in_a_tick(axis), kQuickTick, 1);
}

TEST(LimitedJerk, IsNotInHoming) {
  AxisUnderTest axis;
  limit_jerk(axis, 4'096'000);
  axis.write("homing_method", 34);
  axis.write("op_mode_cmd", 6);
  axis.command(0x000F);
  axis.controlword(0x001F);
  axis.step(2);
  EXPECT_NEAR(std::abs(axis.demand_velocity()), 2 * kNormalTick, kNormalTick + 1)
      << "609Ah at once; with limited jerk 8 UU/s at most";
}

// ---- the bank -----------------------------------------------------------------------------------

/// Axes that all move; the first has limited jerk if `has_jerk`.
AxisBank moving_axes(std::size_t count, bool has_jerk) {
  AxisBank bank(std::vector<AxisConfiguration>(count), std::chrono::microseconds{1000});
  for (std::size_t axis = 0; axis < count; ++axis) {
    const auto write = [&bank, axis](const char* name, std::int64_t value) {
      EXPECT_EQ(bank.write(axis, AxisUnderTest::address_of(name), value), AbortCode::none) << name;
    };
    if (axis == 0 && has_jerk) write("motion_profile_type", 3);
    write("position_user_target_value", 20'000 + 1'000 * static_cast<std::int64_t>(axis));
    write("op_mode_cmd", 1);
    write("ds402_controlword", 0x0F);
    write("ds402_controlword", 0x1F);
  }
  return bank;
}

TEST(LimitedJerk, ChangesNoBitOfTheOtherAxes) {
  constexpr std::size_t kAxes = 10;  // two blocks
  AxisBank with = moving_axes(kAxes, true);
  AxisBank without = moving_axes(kAxes, false);
  for (int tick = 0; tick < 1'500; ++tick) {
    with.step();
    without.step();
    for (std::size_t axis = 1; axis < kAxes; ++axis) {
      const AxisStatus& left = with.status(axis);
      const AxisStatus& right = without.status(axis);
      ASSERT_EQ(left.position_demand_value, right.position_demand_value) << tick;
      ASSERT_EQ(left.load_position_actual_value, right.load_position_actual_value) << tick;
      ASSERT_EQ(left.velocity_demand_value, right.velocity_demand_value) << tick;
      ASSERT_EQ(left.torque_demand, right.torque_demand) << tick;
      ASSERT_EQ(left.ds402_statusword, right.ds402_statusword) << tick;
    }
  }
  EXPECT_EQ(with.status(0).position_demand_value, 20'000);
}

TEST(LimitedJerk, GoesOnFromASnapshot) {
  AxisBank bank = moving_axes(2, true);
  for (int tick = 0; tick < 120; ++tick) bank.step();
  const AxisBank::Snapshot middle = bank.snapshot();
  std::vector<std::int32_t> positions;
  for (int tick = 0; tick < 800; ++tick) {
    bank.step();
    positions.push_back(bank.status(0).load_position_actual_value);
  }
  EXPECT_EQ(bank.status(0).position_demand_value, 20'000);
  bank.restore(bank.snapshot_from(middle.bytes()));
  for (std::size_t tick = 0; tick < positions.size(); ++tick) {
    bank.step();
    ASSERT_EQ(bank.status(0).load_position_actual_value, positions[tick]) << tick;
  }
}

}  // namespace
}  // namespace vdrive
