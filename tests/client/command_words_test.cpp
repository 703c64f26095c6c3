// SPDX-License-Identifier: Apache-2.0
// The controlwords of commands.
#include "vdrive/client/command_words.hpp"

#include "vdrive/cia402/standing_targets.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::client {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(WordsTo, EnableAnAxisByTheWayFromItsState) {
  constexpr auto kEnable = EachCommand::enable;
  EXPECT_THAT(words_to(kEnable, PowerState::switch_on_disabled), ElementsAre(0x06, 0x07, 0x0F));
  EXPECT_THAT(words_to(kEnable, PowerState::ready_to_switch_on), ElementsAre(0x07, 0x0F));
  EXPECT_THAT(words_to(kEnable, PowerState::switched_on), ElementsAre(0x0F));
  EXPECT_THAT(words_to(kEnable, PowerState::operation_enabled), IsEmpty());
}

TEST(WordsTo, EnableAnAxisInQuickStopActiveWithoutItsPowerUnlessItMayKeepIt) {
  constexpr auto kState = PowerState::quick_stop_active;
  EXPECT_THAT(words_to(EachCommand::enable, kState), ElementsAre(0x00, 0x06, 0x07, 0x0F));
  EXPECT_THAT(words_to(EachCommand::enable, kState, {.keeps_power = true}), ElementsAre(0x0F));
}

TEST(WordsTo, EnableAnAxisInAFaultOnlyWhereTheFaultMayBeReset) {
  EXPECT_THAT(words_to(EachCommand::enable, PowerState::fault), IsEmpty());
  EXPECT_THAT(words_to(EachCommand::enable, PowerState::fault, {.resets_fault = true}),
              ElementsAre(0x80, 0x06, 0x07, 0x0F));
}

TEST(WordsTo, EnableNoAxisWhoseStateTakesNoWord) {
  for (const PowerState state :
       {PowerState::not_ready_to_switch_on, PowerState::fault_reaction_active}) {
    EXPECT_THAT(words_to(EachCommand::enable, state, {.resets_fault = true}), IsEmpty());
  }
}

TEST(WordsTo, DisableAnAxisThatStaysInQuickStopActiveByWayOfDisableVoltage) {
  EXPECT_THAT(words_to(EachCommand::disable, PowerState::operation_enabled), ElementsAre(0x06));
  EXPECT_THAT(words_to(EachCommand::disable, PowerState::quick_stop_active),
              ElementsAre(0x00, 0x06));
}

TEST(WordsTo, ResetAFaultByAnEdgeThatLeavesRoomForTheNext) {
  EXPECT_THAT(words_to(EachCommand::reset_fault, PowerState::fault), ElementsAre(0x00, 0x80, 0x00));
  EXPECT_TRUE(words_to(EachCommand::reset_fault, PowerState::operation_enabled).empty());
}

TEST(WordsTo, HaltResumeAndStopByOneWord) {
  constexpr auto kState = PowerState::operation_enabled;
  EXPECT_THAT(words_to(EachCommand::halt, kState), ElementsAre(0x010F));
  EXPECT_THAT(words_to(EachCommand::resume, kState), ElementsAre(0x0F));
  EXPECT_THAT(words_to(EachCommand::quick_stop, kState), ElementsAre(0x02));
}

TEST(SetPointsTo, BringAnAxisToRestWithTheLastWordOfEnabling) {
  AxisSnapshot axis;
  axis.id = {.bench = 1, .axis = 7};
  axis.status.ds402_statusword = 0x0250;  // Switch on disabled: x1xx 0000b
  const auto points = set_points_to(EachCommand::enable, axis);
  ASSERT_EQ(points.size(), 3U);
  EXPECT_EQ(points[2].axis, 7);
  EXPECT_EQ(points[2].controlword, 0x0F);
  EXPECT_THAT(points[1].objects, IsEmpty());
  const std::vector<ObjectAddress> at_rest(kStandingTargets.begin(), kStandingTargets.end());
  std::vector<ObjectAddress> written;
  for (const ObjectValue& value : points[2].objects) {
    EXPECT_EQ(value.value, 0);
    written.push_back(value.object);
  }
  EXPECT_EQ(written, at_rest);
}

}  // namespace
}  // namespace vdrive::client
