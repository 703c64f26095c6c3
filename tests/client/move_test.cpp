// SPDX-License-Identifier: Apache-2.0
// Axis::move_to and move_by: parameters for one move, impossible moves, software limits.
#include "client/objects.hpp"
#include "support/bench_on_wire.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::options_on_wire;
using testing::AllOf;
using testing::HasSubstr;

// 68267 UU/s and 409600 UU/s², as in the table of the manual.
constexpr std::int64_t kDefaultVelocity = 68'267;
constexpr std::int64_t kDefaultRamp = 409'600;

using Limit = std::optional<std::uint32_t>;

MoveOptions with(Limit velocity, Limit acceleration = {}, Limit deceleration = {}) {
  return {
      .velocity = velocity, .acceleration = acceleration, .deceleration = deceleration, .call = {}};
}

MoveOptions not_awaited(MoveOptions options) {
  options.call.until = Until::in_force;
  return options;
}

/// An enabled axis in lock-step.
class Move : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(axis_.enable()); }

  void write(ObjectAddress object, std::int64_t value) {
    ASSERT_TRUE(axis_.write(object, value));
    ASSERT_TRUE(session_.step(1, 1));
  }

  [[nodiscard]] std::int64_t value_of(ObjectAddress object) const {
    const auto value = axis_.read(object);
    EXPECT_TRUE(value) << value.outcome().message();
    return value ? *value : -1;
  }

  void expect_defaults() const {
    EXPECT_EQ(value_of(kVelocity), kDefaultVelocity);
    EXPECT_EQ(value_of(kAcceleration), kDefaultRamp);
    EXPECT_EQ(value_of(kDeceleration), kDefaultRamp);
  }

 private:
  test::BenchOnWire bench_{"--clock lockstep"};

 protected:
  Session session_{options_on_wire()};
  Axis axis_ = *session_.axis("1.1");
};

TEST_F(Move, WithoutSpeedOrRampIsRefusedAtOnceAndChangesNothing) {
  struct Row {
    MoveOptions options;
    const char* object;
  };

  const std::uint64_t before = axis_.status()->tick;
  for (const Row& row :
       {Row{with(0), "profile_velocity (6081h) is 0"}, Row{with({}, 0), "profile_acc (6083h) is 0"},
        Row{with({}, {}, 0), "profile_dec (6084h) is 0"}}) {
    const Outcome refused = axis_.move_to(1000, row.options);
    EXPECT_EQ(refused.kind(), OutcomeKind::refused) << row.object;
    EXPECT_EQ(refused.code(), kRefusedInState) << row.object;
    EXPECT_THAT(refused.message(), AllOf(HasSubstr(row.object), HasSubstr("cannot move")));
    expect_defaults();
  }
  EXPECT_EQ(axis_.status()->tick, before) << "no drive time passed";
  EXPECT_TRUE(axis_.move_to(1000)) << "a later move is not touched";
}

TEST_F(Move, NeedsASpeedWhereTheDriveHasNone) {
  write(kVelocity, 0);
  EXPECT_THAT(axis_.move_to(1000).message(), HasSubstr("profile_velocity (6081h) is 0"));
  EXPECT_TRUE(axis_.move_to(1000, with(5000)));
  EXPECT_EQ(value_of(kDemand), 1000);
  EXPECT_EQ(value_of(kVelocity), 0) << "as before";
  write(kVelocity, 5000);
  write(kSpeedLimit, 0);
  EXPECT_THAT(axis_.move_to(0).message(), HasSubstr("app_speed_limit (607Fh) is 0"));
}

// 1000 UU at 1000 UU/s with ramps of 10000 UU/s² take 1.1 s; with the defaults 0.1 s.
TEST_F(Move, RestoresSpeedAndRampsOfTheDriveAtItsEnd) {
  const std::uint64_t start = axis_.status()->tick;
  ASSERT_TRUE(axis_.move_to(1000, with(1000, 10'000, 10'000)));
  EXPECT_GT(axis_.status()->tick, start + 1'100);
  expect_defaults();
  EXPECT_TRUE(axis_.status()->shows(Statusword::kTargetReached));
  const std::uint64_t next = axis_.status()->tick;
  ASSERT_TRUE(axis_.move_to(0));
  EXPECT_LT(axis_.status()->tick, next + 500);
}

TEST_F(Move, WithoutWaitingKeepsItsSpeedAndLeavesItsRampsInTheDrive) {
  const std::uint64_t start = axis_.status()->tick;
  ASSERT_TRUE(axis_.move_to(1000, not_awaited(with(1000, 10'000, 10'000))));
  EXPECT_EQ(value_of(kVelocity), kDefaultVelocity);
  EXPECT_EQ(value_of(kAcceleration), 10'000);
  const auto reached = axis_.wait_until(
      [](const AxisSnapshot& axis) {
        return axis.status.position_demand_value == 1000;
      },
      5s);
  ASSERT_TRUE(reached);
  // 6062h rounds to the target 10 ms before the end, because the last half unit takes that long at
  // 10000 UU/s².
  EXPECT_GE(reached->tick, start + 1'085) << "6081h was latched";
}

TEST_F(Move, EndedByAFaultRestoresSpeedAndRamps) {
  ASSERT_TRUE(axis_.write({0x5E01, 0}, 1));  // blocked load
  EXPECT_EQ(axis_.move_to(1'000'000, with(50'000, 100'000)).kind(), OutcomeKind::failed);
  expect_defaults();
}

TEST_F(Move, WithoutRoomInTheBufferRestoresSpeedAndRamps) {
  MoveOptions slow = not_awaited(with(1000));
  slow.queue = true;
  ASSERT_TRUE(axis_.move_to(100'000, slow));
  ASSERT_TRUE(axis_.move_to(110'000, slow));
  slow.acceleration = 5;
  slow.velocity = 7;
  EXPECT_EQ(axis_.move_to(120'000, slow).code(), kRefusedInState);
  expect_defaults();
}

TEST_F(Move, ReportsThatASoftwareLimitClampsIt) {
  write(kLowerLimit, -500);
  write(kUpperLimit, 1000);
  EXPECT_TRUE(axis_.move_to(8000)) << "3535h is 0: no limit";
  EXPECT_TRUE(axis_.move_to(0));
  write(kLimitSwitch, 1);
  const Outcome cut = axis_.move_to(8000);
  EXPECT_EQ(cut.kind(), OutcomeKind::failed);
  EXPECT_THAT(cut.message(),
              AllOf(HasSubstr("user_position_upper_limit (607Dh:2) = 1000"), HasSubstr("8000")));
  EXPECT_EQ(value_of(kDemand), 1000);
  EXPECT_THAT(axis_.move_to(-501).message(),
              HasSubstr("user_position_lower_limit (607Dh:1) = -500"));
}

TEST_F(Move, ToASoftwareLimitIsNotClamped) {
  write(kUpperLimit, 1000);
  write(kLimitSwitch, 1);
  EXPECT_TRUE(axis_.move_to(1000));
  EXPECT_TRUE(axis_.status()->shows(Statusword::kInternalLimitActive));
  EXPECT_TRUE(axis_.move_by(-300));
}

// 60F2h: 0 = relative to the last target, 1 = relative to the demand.
TEST_F(Move, ByADistanceIsComparedWithLimitsFromItsBase) {
  write(kUpperLimit, 1000);
  write(kLimitSwitch, 1);
  for (const std::int64_t option : {0, 1}) {
    write(kPositioningOption, option);
    ASSERT_TRUE(axis_.move_to(400)) << option;
    EXPECT_TRUE(axis_.move_by(600)) << option << ": to the limit";
    ASSERT_TRUE(axis_.move_to(400)) << option;
    EXPECT_THAT(axis_.move_by(601).message(), HasSubstr("the move to 1001")) << option;
  }
}

TEST_F(Move, IntoALimitSwitchIsReportedAtOnceAndRestoresSpeedAndRamps) {
  ASSERT_TRUE(axis_.disturb(Disturbance::positive_limit));
  const std::uint64_t start = axis_.status()->tick;
  const Outcome ended = axis_.move_to(8000, with(1000, 10'000, 10'000));
  EXPECT_EQ(ended.kind(), OutcomeKind::failed);
  EXPECT_THAT(ended.message(), HasSubstr("the positive limit switch (60FDh bit 1) ended the move "
                                         "to 8000 UU (703.12 deg) at position 0 UU (0.00 deg)"));
  EXPECT_LT(axis_.status()->tick, start + 20);
  expect_defaults();
  EXPECT_TRUE(axis_.move_to(-500)) << "the other way is free";
  EXPECT_THAT(axis_.move_by(600).message(), HasSubstr("ended the move to 100"));
}

// After 100 ms at the default ramp the axis moves at 40960 UU/s and has travelled some 2000 UU.
TEST_F(Move, EndsAtALimitSwitchThatItReaches) {
  const auto motion = axis_.start_move(-1'000'000);
  ASSERT_TRUE(motion) << motion.outcome().message();
  ASSERT_TRUE(session_.step(1, 100));
  ASSERT_TRUE(axis_.disturb(Disturbance::negative_limit));
  const Outcome ended = motion->wait();
  EXPECT_EQ(ended.kind(), OutcomeKind::failed);
  EXPECT_THAT(ended.message(), AllOf(HasSubstr("the negative limit switch (60FDh bit 0)"),
                                     HasSubstr("the move to -1000000")));
  EXPECT_GT(axis_.status()->status.load_position_actual_value, -100'000);
  EXPECT_EQ(motion->has_ended().outcome().kind(), OutcomeKind::failed);
}

}  // namespace
}  // namespace vdrive::client
