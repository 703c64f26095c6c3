// SPDX-License-Identifier: Apache-2.0
#include "token_bucket.hpp"

#include <gtest/gtest.h>

namespace vdrive::service {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::steady_clock::time_point kBegin{1h};

/// @return how many tokens there are.
int empty(TokenBucket& bucket) {
  int taken = 0;
  while (bucket.take()) {
    ++taken;
  }
  return taken;
}

TEST(TokenBucket, BeginsWithOneBurst) {
  TokenBucket bucket({.per_second = 100.0, .burst = 8.0});
  bucket.refill(kBegin);
  EXPECT_FALSE(bucket.is_empty());
  EXPECT_EQ(empty(bucket), 8);
  EXPECT_TRUE(bucket.is_empty());
}

TEST(TokenBucket, GivesItsRateAndNeverMoreThanABurstAtOnce) {
  TokenBucket bucket({.per_second = 100.0, .burst = 8.0});
  bucket.refill(kBegin);
  static_cast<void>(empty(bucket));
  bucket.refill(kBegin + 9ms);  // 0.9 tokens
  EXPECT_EQ(empty(bucket), 0);
  bucket.refill(kBegin + 55ms);  // 5.5 tokens
  EXPECT_EQ(empty(bucket), 5);
  bucket.refill(kBegin + 10s);  // 1000 would be due
  EXPECT_EQ(empty(bucket), 8);
}

}  // namespace
}  // namespace vdrive::service
