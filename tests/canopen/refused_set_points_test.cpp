// SPDX-License-Identifier: Apache-2.0
#include "bridge/refused_set_points.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace vdrive::canopen {
namespace {

client::SetPointRefusal refusal_of_mode(std::uint16_t axis) {
  return {.axis = {.bench = 1, .axis = axis},
          .object = {.index = 0x6060, .subindex = 0},
          .code = AbortCode::value_range_exceeded};
}

TEST(RefusedSetPoints, CountEqualOnesInOneEntry) {
  RefusedSetPoints refused([] {});
  refused.note(refusal_of_mode(2));
  refused.note(refusal_of_mode(1));
  refused.note(refusal_of_mode(2));
  const std::vector<RefusedSetPoints::Count> taken = refused.take();
  ASSERT_EQ(taken.size(), 2U);
  EXPECT_EQ(taken[0].refusal, refusal_of_mode(1));
  EXPECT_EQ(taken[0].count, 1U);
  EXPECT_EQ(taken[1].refusal, refusal_of_mode(2));
  EXPECT_EQ(taken[1].count, 2U);
  EXPECT_TRUE(refused.take().empty());
}

TEST(RefusedSetPoints, NotifyOnceUntilTheyAreTaken) {
  int notified = 0;
  RefusedSetPoints refused([&notified] {
    ++notified;
  });
  refused.note(refusal_of_mode(1));
  refused.note(refusal_of_mode(2));
  EXPECT_EQ(notified, 1);
  (void)refused.take();
  refused.note(refusal_of_mode(1));
  EXPECT_EQ(notified, 2);
}

}  // namespace
}  // namespace vdrive::canopen
