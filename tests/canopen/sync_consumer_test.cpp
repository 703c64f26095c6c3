// SPDX-License-Identifier: Apache-2.0
#include "node/sync_consumer.hpp"

#include "canopen/pdo_support.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;

SyncConsumer sync_consumer() {
  return SyncConsumer(std::nullopt);
}

/// A consumer that expects counter values from 1 to 10.
SyncConsumer counting_consumer() {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.write({0x1019, 0}, 10), AbortCode::none);
  return sync;
}

TEST(SyncConsumer, HasItsFourObjects) {
  for (const std::uint16_t index : {std::uint16_t{0x1005}, std::uint16_t{0x1006},
                                    std::uint16_t{0x1007}, std::uint16_t{0x1019}}) {
    EXPECT_TRUE(SyncConsumer::has({index, 0})) << index;
    EXPECT_FALSE(SyncConsumer::has({index, 1})) << index;
  }
  EXPECT_FALSE(SyncConsumer::has({0x1008, 0}));
  EXPECT_FALSE(SyncConsumer::has({0x1400, 0}));
}

TEST(SyncConsumer, AwaitsSyncWithoutCounterAt80hByDefault) {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.read({0x1005, 0}), 0x80U);
  EXPECT_EQ(sync.read({0x1006, 0}), 0U);
  EXPECT_EQ(sync.read({0x1007, 0}), 0U);
  EXPECT_EQ(sync.read({0x1019, 0}), 0U);
  EXPECT_TRUE(sync.is_sync(pdo_frame(0x80)));
  const SyncReception reception = sync.receive(pdo_frame(0x80), 0ms);
  EXPECT_TRUE(reception.is_used);
  EXPECT_EQ(reception.counter, 0);
  EXPECT_EQ(reception.error_code, 0);
}

TEST(SyncConsumer, TakesAnotherCanId) {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.write({0x1005, 0}, 0x100), AbortCode::none);
  EXPECT_FALSE(sync.is_sync(pdo_frame(0x80)));
  EXPECT_TRUE(sync.is_sync(pdo_frame(0x100)));
}

TEST(SyncConsumer, RefusesToProduceSyncWith06090030) {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.write({0x1005, 0}, 0x40000080), AbortCode::value_range_exceeded);
  EXPECT_EQ(sync.read({0x1005, 0}), 0x80U);
}

TEST(SyncConsumer, RefusesTheExtendedFormatWith06090030) {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.write({0x1005, 0}, 0x20000080), AbortCode::value_range_exceeded);
  EXPECT_EQ(sync.write({0x1005, 0}, 0x00000880), AbortCode::value_range_exceeded);  // bit 11
}

TEST(SyncConsumer, RefusesRestrictedCanIdsWith06090030) {
  SyncConsumer sync = sync_consumer();
  for (const std::uint32_t can_id :
       {0x000U, 0x07FU, 0x101U, 0x180U, 0x581U, 0x601U, 0x6E0U, 0x701U, 0x7FFU}) {
    EXPECT_EQ(sync.write({0x1005, 0}, can_id), AbortCode::value_range_exceeded) << can_id;
  }
}

TEST(SyncConsumer, KeepsBit31WhichHasNoMeaning) {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.write({0x1005, 0}, 0x80000080), AbortCode::none);
  EXPECT_EQ(sync.read({0x1005, 0}), 0x80000080U);
  EXPECT_TRUE(sync.is_sync(pdo_frame(0x80)));
}

TEST(SyncConsumer, TakesAnyPeriodWhenTimeIsNotStepped) {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.write({0x1006, 0}, 12'345), AbortCode::none);
  EXPECT_EQ(sync.write({0x1006, 0}, 0xFFFFFFFF), AbortCode::none);
  EXPECT_EQ(sync.read({0x1006, 0}), 0xFFFFFFFFU);
}

TEST(SyncConsumer, TakesNoOtherPeriodThanTheSteppedOneWith06090030) {
  SyncConsumer sync(10'000U);
  EXPECT_EQ(sync.write({0x1006, 0}, 10'000), AbortCode::none);
  EXPECT_EQ(sync.write({0x1006, 0}, 10'001), AbortCode::value_range_exceeded);
  EXPECT_EQ(sync.read({0x1006, 0}), 10'000U);
  EXPECT_EQ(sync.write({0x1006, 0}, 0), AbortCode::none);
}

TEST(SyncConsumer, TakesOverflowValues0And2To240) {
  SyncConsumer sync = sync_consumer();
  for (std::uint32_t value = 0; value <= 256; ++value) {
    const bool is_known = value == 0 || (value >= 2 && value <= 240);
    EXPECT_EQ(sync.write({0x1019, 0}, value),
              is_known ? AbortCode::none : AbortCode::value_range_exceeded)
        << value;
  }
}

TEST(SyncConsumer, RefusesAnotherOverflowValueWhileThePeriodIsNotZeroWith08000022) {
  SyncConsumer sync = counting_consumer();
  EXPECT_EQ(sync.write({0x1006, 0}, 1'000), AbortCode::none);
  EXPECT_EQ(sync.write({0x1019, 0}, 20), AbortCode::refused_in_present_device_state);
  EXPECT_EQ(sync.write({0x1019, 0}, 0), AbortCode::refused_in_present_device_state);
  EXPECT_EQ(sync.write({0x1019, 0}, 10), AbortCode::none);  // no change
  EXPECT_EQ(sync.write({0x1006, 0}, 0), AbortCode::none);
  EXPECT_EQ(sync.write({0x1019, 0}, 20), AbortCode::none);
}

TEST(SyncConsumer, TakesOnlyDataFramesInTheBaseFormatForSync) {
  const SyncConsumer sync = sync_consumer();
  EXPECT_FALSE(sync.is_sync(pdo_request(0x80)));
  Frame extended = pdo_frame(0x80);
  extended.is_extended = true;
  EXPECT_FALSE(sync.is_sync(extended));
}

TEST(SyncConsumer, PassesTheCounter) {
  SyncConsumer sync = counting_consumer();
  const SyncReception reception = sync.receive(pdo_frame(0x80, {7}), 0ms);
  EXPECT_TRUE(reception.is_used);
  EXPECT_EQ(reception.counter, 7);
}

TEST(SyncConsumer, DoesNotUseASyncWithACounterThatItDoesNotAwait) {
  SyncConsumer sync = sync_consumer();
  const SyncReception reception = sync.receive(pdo_frame(0x80, {1}), 0ms);
  EXPECT_FALSE(reception.is_used);
  EXPECT_EQ(reception.error_code, 0x8240);
}

TEST(SyncConsumer, DoesNotUseASyncOfAnotherLengthThanOneByteWhenItAwaitsACounter) {
  SyncConsumer without = counting_consumer();
  EXPECT_EQ(without.receive(pdo_frame(0x80), 0ms).error_code, 0x8240);
  SyncConsumer longer = counting_consumer();
  const SyncReception reception = longer.receive(pdo_frame(0x80, {1, 2}), 0ms);
  EXPECT_FALSE(reception.is_used);
  EXPECT_EQ(reception.error_code, 0x8240);
}

TEST(SyncConsumer, RaisesAWrongLengthOnceUntilTheLengthIsRight) {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.receive(pdo_frame(0x80, {1}), 0ms).error_code, 0x8240);
  EXPECT_EQ(sync.receive(pdo_frame(0x80, {2}), 1ms).error_code, 0);
  EXPECT_TRUE(sync.receive(pdo_frame(0x80), 2ms).is_used);
  EXPECT_EQ(sync.receive(pdo_frame(0x80, {3}), 3ms).error_code, 0x8240);
}

TEST(SyncConsumer, HasNoWindowByDefault) {
  SyncConsumer sync = sync_consumer();
  sync.receive(pdo_frame(0x80), 0ms);
  EXPECT_FALSE(sync.is_window_over(1h));
}

TEST(SyncConsumer, ClosesItsWindowAfterItsLengthUntilTheNextSync) {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.write({0x1007, 0}, 2'000), AbortCode::none);  // us
  EXPECT_FALSE(sync.is_window_over(1s));                       // no SYNC yet
  sync.receive(pdo_frame(0x80), 1s);
  EXPECT_FALSE(sync.is_window_over(1'002ms));
  EXPECT_TRUE(sync.is_window_over(1'002'001us));
  sync.receive(pdo_frame(0x80), 1'010ms);
  EXPECT_FALSE(sync.is_window_over(1'011ms));
}

TEST(SyncConsumer, KeepsItsWindowClosedOverASyncThatItDoesNotUse) {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.write({0x1007, 0}, 2'000), AbortCode::none);
  sync.receive(pdo_frame(0x80), 0ms);
  sync.receive(pdo_frame(0x80, {1}), 10ms);
  EXPECT_TRUE(sync.is_window_over(10ms));
}

TEST(SyncConsumer, HasReceivedNoSyncAfterARestart) {
  SyncConsumer sync = sync_consumer();
  EXPECT_EQ(sync.write({0x1007, 0}, 2'000), AbortCode::none);
  sync.receive(pdo_frame(0x80), 0ms);
  sync.restart();
  EXPECT_FALSE(sync.is_window_over(1s));
  EXPECT_EQ(sync.read({0x1007, 0}), 2'000U);
}

TEST(SyncConsumer, HasItsDefaultsAgainAfterAReset) {
  SyncConsumer sync = counting_consumer();
  EXPECT_EQ(sync.write({0x1005, 0}, 0x100), AbortCode::none);
  sync.reset();
  EXPECT_EQ(sync.read({0x1005, 0}), 0x80U);
  EXPECT_EQ(sync.read({0x1019, 0}), 0U);
}

}  // namespace
}  // namespace vdrive::canopen
