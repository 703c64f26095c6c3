// SPDX-License-Identifier: Apache-2.0
#include "engine/control_table.hpp"

#include <gtest/gtest.h>

namespace vdrive::service {
namespace {

TEST(ControlTable, RenewsOneEpochForAllAxesOfASession) {
  ControlTable table(3);
  SessionRecord& record = *table.find_or_add(7, 0);
  table.give(0, record);
  table.renew_epoch(record);
  const std::uint32_t first = record.epoch;
  table.give(2, record);
  table.renew_epoch(record);
  EXPECT_GT(record.epoch, first);
  EXPECT_EQ(table.owner(0).epoch, record.epoch);
  EXPECT_EQ(table.owner(2).epoch, record.epoch);
  EXPECT_EQ(table.owner(1).session, 0U);
  EXPECT_EQ(record.owned_axes, 2U);
}

TEST(ControlTable, HasNoEpochForASessionWithoutAxes) {
  ControlTable table(1);
  SessionRecord& record = *table.find_or_add(7, 0);
  table.give(0, record);
  table.renew_epoch(record);
  table.take(0);
  table.renew_epoch(record);
  EXPECT_EQ(record.epoch, 0U);
  EXPECT_EQ(table.owner(0).session, 0U);
}

TEST(ControlTable, NeverGivesAnEpochTwice) {
  ControlTable table(2);
  SessionRecord& first = *table.find_or_add(1, 0);
  SessionRecord& second = *table.find_or_add(2, 0);
  table.give(0, first);
  table.renew_epoch(first);
  const std::uint32_t old = first.epoch;
  table.give(0, second);
  table.renew_epoch(first);
  table.renew_epoch(second);
  EXPECT_EQ(first.owned_axes, 0U);
  EXPECT_EQ(second.owned_axes, 1U);
  EXPECT_NE(second.epoch, old);
}

TEST(ControlTable, DropsTheLeastRecentlyActiveSessionWhenFull) {
  ControlTable table(1);
  SessionRecord& owner = *table.find_or_add(1, 0);
  table.give(0, owner);
  for (std::uint64_t session = 2; session <= ControlTable::kMaxSessions; ++session) {
    ASSERT_NE(table.find_or_add(session, session), nullptr);
  }
  ASSERT_NE(table.find_or_add(5'000, 9'999), nullptr);
  EXPECT_NE(table.find(1), nullptr) << "an owner is never forgotten";
  EXPECT_EQ(table.find(2), nullptr);
  EXPECT_NE(table.find(3), nullptr);
}

}  // namespace
}  // namespace vdrive::service
