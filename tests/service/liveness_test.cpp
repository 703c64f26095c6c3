// SPDX-License-Identifier: Apache-2.0
#include "run/liveness.hpp"

#include <gtest/gtest.h>

namespace vdrive::test {
namespace {

using service::Counter;
using service::Liveness;

TEST(Liveness, HasBegunWhenEveryThreadHasBegun) {
  Counter ticks;
  Counter status;
  const Liveness liveness({&ticks, &status});
  EXPECT_FALSE(liveness.has_begun());
  ticks.add();
  EXPECT_FALSE(liveness.has_begun());
  status.add();
  EXPECT_TRUE(liveness.has_begun());
}

TEST(Liveness, EndsWhenTheFirstThreadStandsStill) {
  Counter ticks;
  Counter status;
  Liveness liveness({&ticks, &status});
  ticks.add();
  status.add();
  EXPECT_TRUE(liveness.has_advanced());
  ticks.add(1'000);
  EXPECT_FALSE(liveness.has_advanced()) << "status stands";
  status.add();
  EXPECT_FALSE(liveness.has_advanced()) << "ticks stand";
  ticks.add();
  status.add();
  EXPECT_TRUE(liveness.has_advanced()) << "both advance";
}

TEST(Liveness, NeverBeginsWithoutThreads) {
  Liveness liveness({});
  EXPECT_FALSE(liveness.has_begun());
  EXPECT_FALSE(liveness.has_advanced());
}

}  // namespace
}  // namespace vdrive::test
