// SPDX-License-Identifier: Apache-2.0
#include "vdrive/token_bucket.hpp"

#include <gtest/gtest.h>

namespace vdrive {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::nanoseconds kBegin = 1h;

/// @return the number of tokens in the bucket, all of which it takes.
int empty(TokenBucket& bucket) {
  int taken = 0;
  while (bucket.take()) ++taken;
  return taken;
}

TEST(TokenBucket, StartsWithOneBurst) {
  TokenBucket bucket({.per_second = 100.0, .burst = 8.0});
  bucket.refill(kBegin);
  EXPECT_FALSE(bucket.is_empty());
  EXPECT_EQ(empty(bucket), 8);
  EXPECT_TRUE(bucket.is_empty());
}

TEST(TokenBucket, AllowsItsRateAndNeverMoreThanABurstAtOnce) {
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

TEST(TokenBucket, GivesSeveralTokensTogetherOrNone) {
  TokenBucket bucket({.per_second = 10.0, .burst = 3.0});
  bucket.refill(kBegin);
  EXPECT_FALSE(bucket.take(4.0)) << "more than a burst";
  EXPECT_TRUE(bucket.take(3.0)) << "the refusal before took nothing";
  bucket.refill(kBegin + 250ms);  // 2.5 tokens
  EXPECT_FALSE(bucket.take(2.75));
  EXPECT_TRUE(bucket.take(2.5));
}

TEST(TokenBucket, GivesNothingForATimeThatGoesBack) {
  TokenBucket bucket({.per_second = 10.0, .burst = 3.0});
  bucket.refill(kBegin);
  EXPECT_TRUE(bucket.take(2.0));
  bucket.refill(kBegin - 10s);
  EXPECT_EQ(empty(bucket), 1) << "neither more nor less than before";
}

TEST(CountingLimit, TellsHowManyItHasLeftOut) {
  CountingLimit sut({.per_second = 1.0, .burst = 1.0});
  EXPECT_EQ(sut.pass(kBegin), 0U);
  EXPECT_EQ(sut.pass(kBegin + 250ms), std::nullopt);
  EXPECT_EQ(sut.pass(kBegin + 750ms), std::nullopt);
  sut.leave_out();
  EXPECT_EQ(sut.left_out(), 3U);
  EXPECT_EQ(sut.pass(kBegin + 1s), 3U);
  EXPECT_EQ(sut.pass(kBegin + 5s), 0U);
}

}  // namespace
}  // namespace vdrive
