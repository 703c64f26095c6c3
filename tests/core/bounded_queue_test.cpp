// SPDX-License-Identifier: Apache-2.0
#include "vdrive/bounded_queue.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <optional>

namespace vdrive {
namespace {

TEST(BoundedQueue, GivesItemsInTheirOrder) {
  BoundedQueue<int> queue(3, WhenFull::drops_oldest);
  EXPECT_TRUE(queue.put(1));
  EXPECT_TRUE(queue.put(2));
  EXPECT_EQ(queue.take(), 1);
  EXPECT_EQ(queue.take(), 2);
  EXPECT_EQ(queue.take(), std::nullopt);
  EXPECT_EQ(queue.dropped(), 0U);
}

TEST(BoundedQueue, DropsAndCountsTheOldestItemsWhereTheNewestCount) {
  BoundedQueue<int> queue(2, WhenFull::drops_oldest);
  for (int item = 1; item <= 5; ++item) EXPECT_TRUE(queue.put(item));
  EXPECT_EQ(queue.dropped(), 3U);
  EXPECT_EQ(queue.take_all(), (std::deque{4, 5}));
  EXPECT_TRUE(queue.empty());
}

TEST(BoundedQueue, RefusesAndCountsTheNewestItemsWhereTheOldestCount) {
  BoundedQueue<int> queue(2, WhenFull::refuses_newest);
  EXPECT_TRUE(queue.put(1));
  EXPECT_TRUE(queue.put(2));
  EXPECT_FALSE(queue.put(3));
  EXPECT_EQ(queue.dropped(), 1U);
  EXPECT_EQ(queue.items(), (std::deque{1, 2}));
}

}  // namespace
}  // namespace vdrive
