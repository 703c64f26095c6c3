// SPDX-License-Identifier: Apache-2.0
#include "vdrive/cia402/standing_targets.hpp"

#include "core/support/axis_under_test.hpp"
#include "vdrive/cia402/enabling_words.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

namespace vdrive {
namespace {

using test::AxisUnderTest;

// Longer than any habit makes a drive wait for its power: each is set to 20 ms, or to "on".
constexpr std::uint64_t kLongerThanAHabit = 100;
constexpr std::uint8_t kSubindexes = 14;      // of 5E20h
constexpr std::uint8_t kStatuswordBits = 12;  // a habit that only inverts status bits
constexpr std::uint64_t kTimeToMove = 300;

bool is_target(const ObjectDescription& object) {
  return object.role == Role::command && object.variable_name != "ds402_controlword" &&
         object.variable_name != "op_mode_cmd";
}

/// A drive without power in which a master has left its mode, and 200 in every target and offset.
class LeftDrive {
 public:
  explicit LeftDrive(OperatingMode mode) {
    drive_.write("op_mode_cmd", static_cast<std::int64_t>(mode));
    for (const ObjectDescription& object : kObjectTable) {
      if (is_target(object)) drive_.write(object.variable_name, 200);
    }
    drive_.step(2);
  }

  void set(std::span<const ObjectAddress> targets, std::int64_t value) {
    for (const ObjectAddress target : targets) {
      ASSERT_EQ(drive_.axis().write(target, value), AbortCode::none);
    }
  }

  /// @param more bits of the last word, which the mode needs for a motion
  void enable(std::uint16_t more = 0) {
    for (const std::uint16_t word : enabling_words(PowerState::switch_on_disabled)) {
      drive_.command(word);
      drive_.step(kLongerThanAHabit);
    }
    ASSERT_EQ(drive_.state(), PowerState::operation_enabled);
    drive_.command(static_cast<std::uint16_t>(controlwords::kEnableOperation | more));
  }

  /// @return the farthest that demand and axis move from where the axis was [UU].
  std::int32_t way() {
    std::int32_t farthest = 0;
    for (std::uint64_t tick = 0; tick < kTimeToMove; ++tick) {
      drive_.step();
      farthest = std::max({farthest, std::abs(drive_.demand()), std::abs(drive_.actual())});
    }
    return farthest;
  }

 private:
  AxisUnderTest drive_;
};

// Tries every mode with each habit alone; positions, records and offsets are left as they are.
TEST(StandingTargets, OfZeroLetAnAxisRestThatGetsItsPower) {
  for (const OperatingModeRow& mode : kOperatingModes) {
    for (std::uint8_t habit = 0; habit <= kSubindexes; ++habit) {
      SCOPED_TRACE(std::string(mode.name) + ", habit " + std::to_string(habit));
      LeftDrive left(mode.mode);
      if (habit != 0 && habit != kStatuswordBits) {
        const ObjectAddress address{0x5E20, habit};
        const std::int64_t highest = describe(*find_object(address)).upper_limit;
        left.set({&address, 1}, std::min<std::int64_t>(highest, 20));
      }
      left.set(kStandingTargets, 0);
      left.enable();
      EXPECT_EQ(left.way(), 0);
    }
  }
}

/// A mode whose standing target starts a motion immediately, and the bits of 6040h that it needs.
struct FollowingMode {
  OperatingMode mode;
  std::uint16_t bits;
};

class StandingTarget : public testing::TestWithParam<FollowingMode> {};

// It is correct that a drive with a standing target moves when it gets its power; the program that
// writes the controlwords must allow for it.
TEST_P(StandingTarget, ThatWasLeftMovesAnAxisThatGetsItsPower) {
  LeftDrive left(GetParam().mode);
  left.enable(GetParam().bits);
  EXPECT_NE(left.way(), 0);
}

INSTANTIATE_TEST_SUITE_P(Modes, StandingTarget,
                         testing::Values(FollowingMode{OperatingMode::velocity, 0x0070},
                                         FollowingMode{OperatingMode::profile_velocity, 0},
                                         FollowingMode{OperatingMode::profile_torque, 0}),
                         [](const auto& info) {
                           return "mode_" + std::to_string(static_cast<int>(info.param.mode));
                         });

}  // namespace
}  // namespace vdrive
