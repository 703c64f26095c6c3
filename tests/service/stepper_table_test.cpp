// SPDX-License-Identifier: Apache-2.0
#include "engine/stepper_table.hpp"

#include <gtest/gtest.h>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kAlice = 0xA11CE;
constexpr std::uint64_t kBob = 0xB0B;

const StepperTable::Time kStart{100s};

/// Alice and Bob, who both joined at tick 7.
struct TwoSteppers {
  TwoSteppers() {
    EXPECT_TRUE(table.join(kAlice, {}, 7, kStart));
    EXPECT_TRUE(table.join(kBob, {}, 7, kStart));
  }

  void grant(std::uint64_t session, std::uint64_t ticks, StepperTable::Time now = kStart) {
    table.grant(*table.find(session), ticks, now);
  }

  StepperTable table;
};

TEST(StepperTable, IsEmptyAtFirst) {
  StepperTable table;
  EXPECT_TRUE(table.empty());
  EXPECT_EQ(table.slowest(), nullptr);
  EXPECT_EQ(table.find(kAlice), nullptr);
  EXPECT_FALSE(table.leave(kAlice, kStart));
}

TEST(StepperTable, WaitsForAsManyAsTheBenchAwaits) {
  StepperTable table(2);
  EXPECT_FALSE(table.is_open());
  EXPECT_TRUE(table.join(kAlice, {}, 0, kStart));
  EXPECT_FALSE(table.is_complete());
  EXPECT_TRUE(table.join(kBob, {}, 0, kStart));
  EXPECT_TRUE(table.is_complete());
  EXPECT_TRUE(table.leave(kAlice, kStart));
  EXPECT_TRUE(table.is_complete()) << "a program that has ended is not awaited";
  EXPECT_TRUE(table.leave(kBob, kStart));
  EXPECT_TRUE(table.join(kAlice, {}, 0, kStart));
  EXPECT_FALSE(table.is_complete()) << "when all have left it waits again";
}

TEST(StepperTable, WaitsForAsManyAsOneOfItsSteppersAwaits) {
  StepperTable table;
  EXPECT_TRUE(table.is_open());
  EXPECT_TRUE(table.join(kAlice, {}, 0, kStart));
  EXPECT_TRUE(table.is_complete()) << "nobody is awaited";
  EXPECT_TRUE(table.join(kBob, {}, 0, kStart, 3));
  EXPECT_FALSE(table.is_complete());
  EXPECT_TRUE(table.join(kBob + 1, {}, 0, kStart));
  EXPECT_TRUE(table.is_complete());
}

// Alice has granted ticks, and Bob is silent while a third stepper is still awaited: he holds up
// nobody.
TEST(StepperTable, TakesNoneForSilentWhileSteppersAreAwaited) {
  StepperTable table(3);
  EXPECT_TRUE(table.join(kAlice, {}, 0, kStart));
  EXPECT_TRUE(table.join(kBob, {}, 0, kStart));
  table.grant(*table.find(kAlice), 5, kStart);
  EXPECT_EQ(table.silent(kStart + 60s), nullptr);
  EXPECT_TRUE(table.join(kBob + 1, {}, 0, kStart + 60s));
  EXPECT_EQ(table.silent(kStart + 69s), nullptr) << "10 s from when he is waited for";
  EXPECT_NE(table.silent(kStart + 70s), nullptr);
}

TEST(StepperTable, AdvancesTimeToTheSmallestGrant) {
  TwoSteppers two;
  EXPECT_EQ(two.table.slowest()->granted, 7U) << "a grant begins at the present tick";
  two.grant(kAlice, 10);
  EXPECT_EQ(two.table.slowest()->session, kBob);
  two.grant(kBob, 3);
  EXPECT_EQ(two.table.slowest()->granted, 10U);
  two.grant(kBob, 20);
  EXPECT_EQ(two.table.slowest()->session, kAlice);
  EXPECT_EQ(two.table.slowest()->granted, 17U);
}

TEST(StepperTable, AddsASessionOnceAndLosesNoGrant) {
  TwoSteppers two;
  two.grant(kAlice, 5);
  EXPECT_TRUE(two.table.join(kAlice, {}, 7, kStart));
  EXPECT_EQ(two.table.size(), 2U);
  EXPECT_EQ(two.table.find(kAlice)->granted, 12U);
}

TEST(StepperTable, DoesNotWaitForAStepperThatLeft) {
  TwoSteppers two;
  two.grant(kAlice, 5);
  EXPECT_TRUE(two.table.leave(kBob, kStart));
  EXPECT_EQ(two.table.slowest()->granted, 12U);
}

TEST(StepperTable, HasRoomForSixtyFour) {
  StepperTable table;
  for (std::uint64_t session = 1; session <= 64; ++session) {
    ASSERT_TRUE(table.join(session, {}, 0, kStart));
  }
  EXPECT_FALSE(table.join(65, {}, 0, kStart));
  EXPECT_TRUE(table.join(64, {}, 0, kStart)) << "is one already";
}

TEST(StepperTable, FindsAStepperThatKeepsOthersWaitingForTenSeconds) {
  TwoSteppers two;
  EXPECT_EQ(two.table.silent(kStart + 100s), nullptr) << "no stepper waits";
  two.grant(kAlice, 1, kStart + 100s);
  EXPECT_EQ(two.table.silent(kStart + 109s), nullptr);
  ASSERT_NE(two.table.silent(kStart + 110s), nullptr);
  EXPECT_EQ(two.table.silent(kStart + 110s)->session, kBob);
}

TEST(StepperTable, KeepsASlowStepperThatSendsMessages) {
  TwoSteppers two;
  two.grant(kAlice, 1'000);
  two.table.note_message(kBob, kStart + 9s);
  EXPECT_EQ(two.table.silent(kStart + 18s), nullptr);
  EXPECT_NE(two.table.silent(kStart + 19s), nullptr);
}

TEST(StepperTable, RestartsTheWaitAfterTheSlowStepperCaughtUp) {
  TwoSteppers two;
  two.grant(kAlice, 5);
  two.grant(kBob, 5, kStart + 9s);
  two.grant(kAlice, 5, kStart + 30s);
  EXPECT_EQ(two.table.silent(kStart + 39s), nullptr);
  EXPECT_NE(two.table.silent(kStart + 40s), nullptr);
}

}  // namespace
}  // namespace vdrive::service
