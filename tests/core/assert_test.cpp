// SPDX-License-Identifier: Apache-2.0
// A broken invariant ends the program where it occurs, in every build that runs tests.
#include "vdrive/assert.hpp"

#include "vdrive/axis_bank.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/motion/profile.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>

namespace vdrive {
namespace {

AxisBank bank_of_one() {
  return {std::array<AxisConfiguration, 1>{}, std::chrono::milliseconds(1)};
}

TEST(Invariant, IsCheckedInABuildWithTests) {
  EXPECT_TRUE(kChecksInvariants);
}

TEST(Invariant, ThatHoldsLetsTheProgramGoOn) {
  ensure(true, "one is one");
  EXPECT_EQ(describe(0).address.index, 0x1000);
}

TEST(InvariantDeathTest, NamesItselfAndThePlaceOfTheCaller) {
  EXPECT_DEATH(ensure(false, "one is two"), "assert_test.cpp:.*one is two");
}

TEST(InvariantDeathTest, ARowOutsideTheDictionaryEndsTheProgram) {
  const auto row = static_cast<ObjectRow>(kObjectTable.size());
  EXPECT_DEATH(static_cast<void>(describe(row)), "inside its table");
}

TEST(InvariantDeathTest, AnAxisThatTheBankDoesNotHaveEndsTheProgram) {
  AxisBank bank = bank_of_one();
  EXPECT_DEATH(static_cast<void>(bank.status(1)), "one of the bank's");
  EXPECT_DEATH(bank.write(1, {0x6040, 0}, 0), "one of the bank's");
  EXPECT_DEATH(bank.step_groups(0, 2), "groups are the bank's");
}

TEST(InvariantDeathTest, ASegmentThatAProfileDoesNotHaveEndsTheProgram) {
  const Profile rest;
  EXPECT_DEATH(static_cast<void>(rest.segment(0)), "the segment that is asked for");
}

}  // namespace
}  // namespace vdrive
