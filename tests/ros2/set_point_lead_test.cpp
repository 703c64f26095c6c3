// SPDX-License-Identifier: Apache-2.0
#include "set_point_lead.hpp"

#include <gtest/gtest.h>

namespace vdrive::ros2 {
namespace {

TEST(SetPointLead, IsWallTimeInTicksOfTheBench) {
  SetPointLead lead(ClockMode::realtime, 0.001);
  EXPECT_EQ(lead.lead(), 8U);
  EXPECT_EQ(lead.window(false), 16U) << "twice the lead is longer than 15 ms";
  EXPECT_EQ(lead.window(true), 150U);
  lead.set_rate(2.0);
  EXPECT_EQ(lead.lead(), 16U);
  EXPECT_EQ(lead.window(true), 300U);
}

TEST(SetPointLead, IsAtLeastATickAndAtMostWhatABenchKeeps) {
  SetPointLead slow(ClockMode::realtime, 0.01);
  slow.set_rate(0.1);
  EXPECT_EQ(slow.lead(), 1U);
  SetPointLead fast(ClockMode::realtime, 0.000125);
  fast.set_rate(10.0);
  EXPECT_EQ(fast.window(true), 400U);
}

TEST(SetPointLead, DoublesAfterSetPointsThatCameTooLateUpToALimit) {
  SetPointLead lead(ClockMode::realtime, 0.001);
  lead.lengthen();
  EXPECT_EQ(lead.lead(), 16U);
  for (int i = 0; i < 10; ++i) lead.lengthen();
  EXPECT_EQ(lead.lead(), 128U);
  EXPECT_EQ(lead.window(false), 256U) << "a window shorter than the lead would send nothing";
}

TEST(SetPointLead, IsCountedInTicksInLockStep) {
  SetPointLead lead(ClockMode::lockstep, 0.001);
  lead.set_rate(50.0);
  lead.lengthen();
  EXPECT_EQ(lead.lead(), 20U);
  EXPECT_EQ(lead.window(false), 40U);
  EXPECT_EQ(lead.window(true), 100U);
  EXPECT_EQ(lead.ahead_of_trajectory(), 50U);
}

}  // namespace
}  // namespace vdrive::ros2
