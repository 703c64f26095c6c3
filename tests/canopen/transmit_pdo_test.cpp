// SPDX-License-Identifier: Apache-2.0
#include "node/transmit_pdo.hpp"

#include "canopen/pdo_support.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::uint8_t kNoCounter = 0;

/// The first TPDO of the node with 6041h and this transmission type; RTR is allowed.
TransmitPdo transmit_pdo_of_type(std::uint32_t type) {
  TransmitPdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x185), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1800, 2}, type), AbortCode::none);
  return pdo;
}

/// The same, event-driven.
/// @param inhibit_time [100 us]
/// @param event_timer [ms]
TransmitPdo transmit_pdo_with_times(std::uint32_t inhibit_time, std::uint32_t event_timer) {
  TransmitPdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x80000185), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1800, 3}, inhibit_time), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1800, 5}, event_timer), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x185), AbortCode::none);
  return pdo;
}

/// @return at which of the SYNCs 1 to `count` a TPDO of this type is sent while its value is
///         constant.
std::vector<int> sent_at_syncs(std::uint32_t type, int count) {
  TransmitPdo pdo = transmit_pdo_of_type(type);
  std::vector<int> sent;
  for (int sync = 1; sync <= count; ++sync) {
    if (pdo.synchronise(pdo_status(0x0237), kNoCounter)) sent.push_back(sync);
  }
  return sent;
}

TEST(TransmitPdo, HasTheCanIdOfThePredefinedConnectionSet) {
  // TPDO 1 to 4: 180h, 280h, 380h, 480h + node id
  EXPECT_EQ(can_id_of(TransmitPdo(pdo_place(1)).read({0x1800, 1})), 0x185U);
  EXPECT_EQ(can_id_of(TransmitPdo(pdo_place(2)).read({0x1801, 1})), 0x285U);
  EXPECT_EQ(can_id_of(TransmitPdo(pdo_place(3)).read({0x1802, 1})), 0x385U);
  EXPECT_EQ(can_id_of(TransmitPdo(pdo_place(4)).read({0x1803, 1})), 0x485U);
}

TEST(TransmitPdo, TakesEachTypeThatIsNotReserved) {
  TransmitPdo pdo(pdo_place(1));
  for (std::uint32_t type = 0; type <= 300; ++type) {
    const bool is_known = type <= 240 || (type >= 252 && type <= 255);
    EXPECT_EQ(pdo.write({0x1800, 2}, type),
              is_known ? AbortCode::none : AbortCode::value_range_exceeded)
        << type;
  }
}

TEST(TransmitPdo, RefusesAnotherCanIdWhileItIsValidWith06090030) {
  TransmitPdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x186), AbortCode::value_range_exceeded);
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x20000185), AbortCode::value_range_exceeded);
}

TEST(TransmitPdo, TakesAnotherBit30WhileItIsValid) {
  TransmitPdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x40000185), AbortCode::none);
  EXPECT_FALSE(pdo.is_request(pdo_request(0x185)));
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x00000185), AbortCode::none);
  EXPECT_TRUE(pdo.is_request(pdo_request(0x185)));
}

TEST(TransmitPdo, RefusesAnotherInhibitTimeWhileItIsValidWith06090030) {
  TransmitPdo pdo(pdo_place(3));
  const std::uint32_t initial = pdo.read({0x1802, 3});
  EXPECT_EQ(pdo.write({0x1802, 3}, initial + 1), AbortCode::value_range_exceeded);
  EXPECT_EQ(pdo.write({0x1802, 3}, initial), AbortCode::none);  // no change
  EXPECT_EQ(pdo.write({0x1802, 1}, 0x80000385), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1802, 3}, initial + 1), AbortCode::none);
  EXPECT_EQ(pdo.read({0x1802, 3}), initial + 1);
  EXPECT_EQ(pdo.write({0x1802, 3}, 0x10000), AbortCode::value_range_exceeded);
}

TEST(TransmitPdo, RefusesAnotherSyncStartValueWhileItIsValidWith06090030) {
  TransmitPdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1800, 6}, 1), AbortCode::value_range_exceeded);
  EXPECT_EQ(pdo.write({0x1800, 6}, 0), AbortCode::none);  // no change
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x80000185), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1800, 6}, 240), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1800, 6}, 241), AbortCode::value_range_exceeded);
  EXPECT_EQ(pdo.read({0x1800, 6}), 240U);
}

TEST(TransmitPdo, TakesAnEventTimerWhileItIsValid) {
  TransmitPdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1800, 5}, 100), AbortCode::none);
  EXPECT_EQ(pdo.read({0x1800, 5}), 100U);
}

TEST(TransmitPdo, PacksNumbersWithTheLeastByteFirst) {
  TransmitPdo pdo(pdo_place(3));  // 6041h and 6064h
  const auto frame = pdo.send_due(pdo_status(0x0237, -2), 0ms);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->id, 0x385U);
  EXPECT_FALSE(frame->is_remote);
  EXPECT_FALSE(frame->is_extended);
  EXPECT_THAT(pdo_bytes(frame), ElementsAre(0x37, 0x02, 0xFE, 0xFF, 0xFF, 0xFF));
}

TEST(TransmitPdo, PacksAnObjectWithTheLengthOfItsType) {
  TransmitPdo pdo(pdo_place(1));
  remap_pdo(pdo, 0x1800, {kMapDigitalInputs, kMapModeDisplay});
  AxisStatus drive;
  drive.digital_inputs = 5;  // one byte in the status, UNSIGNED32 in the dictionary
  drive.op_mode_actual = -1;
  EXPECT_THAT(pdo_bytes(pdo.send_due(drive, 0ms)), ElementsAre(5, 0, 0, 0, 0xFF));
}

TEST(TransmitPdo, SendsOnChange) {
  TransmitPdo pdo = transmit_pdo_with_times(0, 0);
  EXPECT_THAT(pdo_bytes(pdo.send_due(pdo_status(0x0250), 0ms)), ElementsAre(0x50, 0x02));
  EXPECT_FALSE(pdo.send_due(pdo_status(0x0250), 1ms));
  EXPECT_THAT(pdo_bytes(pdo.send_due(pdo_status(0x0231), 2ms)), ElementsAre(0x31, 0x02));
  EXPECT_FALSE(pdo.send_due(pdo_status(0x0231), 10s));
  EXPECT_FALSE(pdo.next_due());
}

TEST(TransmitPdo, DoesNotSendAChangeOfWhatItDoesNotCarry) {
  TransmitPdo pdo = transmit_pdo_with_times(0, 0);
  EXPECT_TRUE(pdo.send_due(pdo_status(0x0250, 1), 0ms));
  EXPECT_FALSE(pdo.send_due(pdo_status(0x0250, 2), 1ms));
}

TEST(TransmitPdo, SendsChangesWithinItsInhibitTimeOnceAtItsEnd) {
  TransmitPdo pdo = transmit_pdo_with_times(100, 0);  // 10 ms
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 100ms));
  EXPECT_FALSE(pdo.next_due());
  EXPECT_FALSE(pdo.send_due(pdo_status(2), 101ms));
  EXPECT_FALSE(pdo.send_due(pdo_status(3), 105ms));
  EXPECT_EQ(pdo.next_due(), DriveTime(110ms));
  EXPECT_FALSE(pdo.send_due(pdo_status(3), 109'999us));
  EXPECT_THAT(pdo_bytes(pdo.send_due(pdo_status(3), 110ms)), ElementsAre(3, 0));
  EXPECT_FALSE(pdo.send_due(pdo_status(3), 120ms));
  EXPECT_FALSE(pdo.next_due());
}

TEST(TransmitPdo, SendsNothingAfterAChangeThatWentAgainWithinItsInhibitTime) {
  TransmitPdo pdo = transmit_pdo_with_times(100, 0);
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 0ms));
  EXPECT_FALSE(pdo.send_due(pdo_status(2), 1ms));
  EXPECT_FALSE(pdo.send_due(pdo_status(1), 2ms));
  EXPECT_FALSE(pdo.next_due());
  EXPECT_FALSE(pdo.send_due(pdo_status(1), 10ms));
}

TEST(TransmitPdo, SendsAtOnceAfterItsInhibitTime) {
  TransmitPdo pdo = transmit_pdo_with_times(100, 0);
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 0ms));
  EXPECT_TRUE(pdo.send_due(pdo_status(2), 50ms));
  EXPECT_FALSE(pdo.send_due(pdo_status(3), 59ms));  // counts from the previous frame
}

TEST(TransmitPdo, SendsUnchangedBytesWhenItsEventTimerHasElapsed) {
  TransmitPdo pdo = transmit_pdo_with_times(0, 50);
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 0ms));
  EXPECT_EQ(pdo.next_due(), DriveTime(50ms));
  EXPECT_FALSE(pdo.send_due(pdo_status(1), 49ms));
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 50ms));
  EXPECT_TRUE(pdo.send_due(pdo_status(2), 70ms));  // a change restarts the timer
  EXPECT_FALSE(pdo.send_due(pdo_status(2), 100ms));
  EXPECT_EQ(pdo.next_due(), DriveTime(120ms));
}

TEST(TransmitPdo, LetsItsInhibitTimePassBeforeAShorterEventTimer) {
  TransmitPdo pdo = transmit_pdo_with_times(200, 5);  // 20 ms, 5 ms
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 0ms));
  EXPECT_EQ(pdo.next_due(), DriveTime(20ms));
  EXPECT_FALSE(pdo.send_due(pdo_status(1), 5ms));
  EXPECT_EQ(pdo.next_due(), DriveTime(20ms));
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 20ms));
}

TEST(TransmitPdo, IsDueAtOnceWhenItHasSentNothing) {
  TransmitPdo pdo = transmit_pdo_with_times(100, 0);
  EXPECT_EQ(pdo.next_due(), DriveTime::zero());
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 0ms));
  pdo.restart();
  EXPECT_EQ(pdo.next_due(), DriveTime::zero());
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 1ms));  // no inhibit time before the first frame
}

TEST(TransmitPdo, OfTypes1To240IsSentAtEveryNthSync) {
  EXPECT_THAT(sent_at_syncs(1, 4), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(sent_at_syncs(2, 6), ElementsAre(2, 4, 6));
  EXPECT_THAT(sent_at_syncs(3, 8), ElementsAre(3, 6));
  EXPECT_THAT(sent_at_syncs(240, 481), ElementsAre(240, 480));
}

TEST(TransmitPdo, OfType0IsSentAtTheSyncAfterAChange) {
  TransmitPdo pdo = transmit_pdo_of_type(0);
  EXPECT_FALSE(pdo.send_due(pdo_status(1), 0ms));
  EXPECT_THAT(pdo_bytes(pdo.synchronise(pdo_status(1), kNoCounter)), ElementsAre(1, 0));
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), kNoCounter));
  EXPECT_FALSE(pdo.send_due(pdo_status(2), 1ms));
  EXPECT_THAT(pdo_bytes(pdo.synchronise(pdo_status(2), kNoCounter)), ElementsAre(2, 0));
}

TEST(TransmitPdo, OfSynchronousTypesWaitsForNoTime) {
  for (const std::uint32_t type : {0U, 1U, 240U, 252U, 253U}) {
    TransmitPdo pdo = transmit_pdo_of_type(type);
    EXPECT_EQ(pdo.write({0x1800, 5}, 10), AbortCode::none);
    EXPECT_FALSE(pdo.send_due(pdo_status(1), 1s)) << type;
    EXPECT_FALSE(pdo.next_due()) << type;
  }
}

TEST(TransmitPdo, OfEventDrivenTypesIsNotSentAtSync) {
  for (const std::uint32_t type : {253U, 254U, 255U}) {
    EXPECT_THAT(sent_at_syncs(type, 3), IsEmpty()) << type;
  }
}

TEST(TransmitPdo, OfType252AnswersWithTheBytesOfTheLastSync) {
  TransmitPdo pdo = transmit_pdo_of_type(252);
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), kNoCounter));
  EXPECT_THAT(pdo_bytes(pdo.answer(pdo_status(2), 1ms)), ElementsAre(1, 0));
  EXPECT_THAT(pdo_bytes(pdo.answer(pdo_status(3), 2ms)), ElementsAre(1, 0));
  EXPECT_FALSE(pdo.synchronise(pdo_status(4), kNoCounter));
  EXPECT_THAT(pdo_bytes(pdo.answer(pdo_status(5), 3ms)), ElementsAre(4, 0));
}

TEST(TransmitPdo, OfType252AnswersWithThePresentBytesBeforeTheFirstSync) {
  TransmitPdo pdo = transmit_pdo_of_type(252);
  EXPECT_THAT(pdo_bytes(pdo.answer(pdo_status(7), 0ms)), ElementsAre(7, 0));
}

TEST(TransmitPdo, OfType253AnswersWithThePresentBytes) {
  TransmitPdo pdo = transmit_pdo_of_type(253);
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), kNoCounter));
  EXPECT_THAT(pdo_bytes(pdo.answer(pdo_status(2), 0ms)), ElementsAre(2, 0));
  EXPECT_THAT(pdo_bytes(pdo.answer(pdo_status(2), 0ms)), ElementsAre(2, 0));
}

TEST(TransmitPdo, OfEventDrivenTypesAnswersWithoutAChange) {
  for (const std::uint32_t type : {254U, 255U}) {
    TransmitPdo pdo = transmit_pdo_of_type(type);
    EXPECT_TRUE(pdo.send_due(pdo_status(1), 0ms));
    EXPECT_THAT(pdo_bytes(pdo.answer(pdo_status(1), 1ms)), ElementsAre(1, 0)) << type;
    EXPECT_FALSE(pdo.send_due(pdo_status(1), 2ms)) << type;
  }
}

TEST(TransmitPdo, AnswersRequestsWithinItsInhibitTimeOnceAtItsEnd) {
  TransmitPdo pdo = transmit_pdo_with_times(100, 0);
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 0ms));
  EXPECT_FALSE(pdo.answer(pdo_status(1), 3ms));
  EXPECT_FALSE(pdo.answer(pdo_status(1), 4ms));
  EXPECT_EQ(pdo.next_due(), DriveTime(10ms));
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 10ms));
  EXPECT_FALSE(pdo.send_due(pdo_status(1), 20ms));
}

TEST(TransmitPdo, OfTypes0To240DoesNotAnswer) {
  for (const std::uint32_t type : {0U, 1U, 240U}) {
    TransmitPdo pdo = transmit_pdo_of_type(type);
    EXPECT_FALSE(pdo.answer(pdo_status(1), 0ms)) << type;
  }
}

TEST(TransmitPdo, IsRequestedByRemoteFramesInTheBaseFormat) {
  TransmitPdo pdo = transmit_pdo_of_type(253);
  EXPECT_TRUE(pdo.is_request(pdo_request(0x185)));
  EXPECT_FALSE(pdo.is_request(pdo_request(0x186)));
  EXPECT_FALSE(pdo.is_request(pdo_frame(0x185)));
  Frame extended = pdo_request(0x185);
  extended.is_extended = true;
  EXPECT_FALSE(pdo.is_request(extended));
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x80000185), AbortCode::none);
  EXPECT_FALSE(pdo.is_request(pdo_request(0x185)));
}

/// A TPDO of this type with SYNC start value 3.
TransmitPdo transmit_pdo_starting_at_3(std::uint32_t type) {
  TransmitPdo pdo = transmit_pdo_of_type(type);
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x80000185), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1800, 6}, 3), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x185), AbortCode::none);
  return pdo;
}

TEST(TransmitPdo, BeginsWithTheSyncOfItsStartValue) {
  TransmitPdo pdo = transmit_pdo_starting_at_3(1);
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), 1));
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), 2));
  EXPECT_TRUE(pdo.synchronise(pdo_status(1), 3));
  EXPECT_TRUE(pdo.synchronise(pdo_status(1), 4));
  EXPECT_TRUE(pdo.synchronise(pdo_status(1), 1));
}

TEST(TransmitPdo, CountsTheSyncOfItsStartValueAsTheFirst) {
  TransmitPdo pdo = transmit_pdo_starting_at_3(2);
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), 2));
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), 3));
  EXPECT_TRUE(pdo.synchronise(pdo_status(1), 4));
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), 5));
  EXPECT_TRUE(pdo.synchronise(pdo_status(1), 6));
}

TEST(TransmitPdo, IgnoresItsStartValueWhenSyncHasNoCounter) {
  TransmitPdo pdo = transmit_pdo_starting_at_3(1);
  EXPECT_TRUE(pdo.synchronise(pdo_status(1), kNoCounter));
}

TEST(TransmitPdo, SendsNothingWhileItIsNotValid) {
  for (const std::uint32_t type : {0U, 1U, 252U, 255U}) {
    TransmitPdo pdo = transmit_pdo_of_type(type);
    EXPECT_EQ(pdo.write({0x1800, 1}, 0x80000185), AbortCode::none);
    EXPECT_FALSE(pdo.synchronise(pdo_status(1), kNoCounter)) << type;
    EXPECT_FALSE(pdo.send_due(pdo_status(1), 0ms)) << type;
    EXPECT_FALSE(pdo.next_due()) << type;
  }
}

TEST(TransmitPdo, SendsAgainWhenItBecomesValid) {
  TransmitPdo pdo = transmit_pdo_with_times(100, 0);
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 0ms));
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x80000185), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x185), AbortCode::none);
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 1ms));
}

TEST(TransmitPdo, BeginsToCountSyncsAgainWithAnotherType) {
  TransmitPdo pdo = transmit_pdo_of_type(2);
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), kNoCounter));
  EXPECT_EQ(pdo.write({0x1800, 2}, 3), AbortCode::none);
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), kNoCounter));
  EXPECT_FALSE(pdo.synchronise(pdo_status(1), kNoCounter));
  EXPECT_EQ(pdo.write({0x1800, 2}, 3), AbortCode::none);  // unchanged
  EXPECT_TRUE(pdo.synchronise(pdo_status(1), kNoCounter));
}

TEST(TransmitPdo, CarriesWhatItIsRemappedTo) {
  TransmitPdo pdo(pdo_place(1));
  remap_pdo(pdo, 0x1800, {kMapStatusword, kMapPosition, kMapModeDisplay});
  AxisStatus drive = pdo_status(0x0237, 0x01020304);
  drive.op_mode_actual = 8;
  EXPECT_THAT(pdo_bytes(pdo.send_due(drive, 0ms)),
              ElementsAre(0x37, 0x02, 0x04, 0x03, 0x02, 0x01, 8));
}

TEST(TransmitPdo, HasItsDefaultsAgainAfterAReset) {
  TransmitPdo pdo = transmit_pdo_of_type(1);
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x80000000), AbortCode::none);
  pdo.reset();
  EXPECT_EQ(can_id_of(pdo.read({0x1800, 1})), 0x185U);
  EXPECT_EQ(pdo.read({0x1800, 2}), 255U);
  EXPECT_TRUE(pdo.send_due(pdo_status(1), 0ms));
}

// ---- objects that are not part of the status ---------------------------------------------------

/// The first TPDO with 6041h and 607Ah, event-driven.
TransmitPdo transmit_pdo_with_target() {
  TransmitPdo pdo(pdo_place(1));
  remap_pdo(pdo, 0x1800, {kMapStatusword, kMapTargetPosition});
  return pdo;
}

std::vector<ObjectAddress> read_objects_of(const TransmitPdo& pdo) {
  std::vector<ObjectAddress> objects;
  pdo.add_read_objects(objects);
  return objects;
}

TEST(TransmitPdo, NamesWhatItCarriesAndTheStatusDoesNotHave) {
  EXPECT_THAT(read_objects_of(TransmitPdo(pdo_place(3))), IsEmpty());
  TransmitPdo pdo = transmit_pdo_with_target();
  EXPECT_THAT(read_objects_of(pdo), ElementsAre(ObjectAddress{0x607A, 0}));
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x80000185), AbortCode::none);
  EXPECT_THAT(read_objects_of(pdo), IsEmpty()) << "it is not valid";
}

TEST(TransmitPdo, NamesAnObjectOnceThatAnotherOneNeedsToo) {
  std::vector<ObjectAddress> objects{{0x607A, 0}};
  transmit_pdo_with_target().add_read_objects(objects);
  EXPECT_THAT(objects, ElementsAre(ObjectAddress{0x607A, 0}));
}

TEST(TransmitPdo, CarriesTheValuesThatWereReadLast) {
  TransmitPdo pdo = transmit_pdo_with_target();
  pdo.set_value(drive_value(0x607A, -2));
  EXPECT_THAT(pdo_bytes(pdo.send_due(pdo_status(0x0237), 0ms)),
              ElementsAre(0x37, 0x02, 0xFE, 0xFF, 0xFF, 0xFF));
  EXPECT_FALSE(pdo.send_due(pdo_status(0x0237), 1ms));
  pdo.set_value(drive_value(0x607A, 3));
  EXPECT_THAT(pdo_bytes(pdo.send_due(pdo_status(0x0237), 2ms)),
              ElementsAre(0x37, 0x02, 3, 0, 0, 0));
}

TEST(TransmitPdo, IsNotSentBeforeItHasTheValueOfEachObject) {
  TransmitPdo pdo(pdo_place(1));
  remap_pdo(pdo, 0x1800, {kMapTargetPosition, kMapMode});
  const AxisStatus drive = pdo_status(0x0237);
  EXPECT_FALSE(pdo.send_due(drive, 0ms));
  EXPECT_FALSE(pdo.next_due()) << "it waits for no time";
  EXPECT_FALSE(pdo.answer(drive, 0ms));
  pdo.set_value(drive_value(0x607A, 1));
  EXPECT_FALSE(pdo.send_due(drive, 1ms));
  pdo.set_value(drive_value(0x6060, 8));
  EXPECT_THAT(pdo_bytes(pdo.send_due(drive, 2ms)), ElementsAre(1, 0, 0, 0, 8));
}

TEST(TransmitPdo, CountsNoSyncBeforeItHasItsValues) {
  TransmitPdo pdo = transmit_pdo_with_target();
  EXPECT_EQ(pdo.write({0x1800, 2}, 2), AbortCode::none);  // every second SYNC
  const AxisStatus drive = pdo_status(0x0237);
  for (int sync = 0; sync < 3; ++sync) EXPECT_FALSE(pdo.synchronise(drive, kNoCounter));
  pdo.set_value(drive_value(0x607A, 1));
  EXPECT_FALSE(pdo.synchronise(drive, kNoCounter));
  EXPECT_TRUE(pdo.synchronise(drive, kNoCounter));
}

TEST(TransmitPdo, IgnoresTheValueOfAnObjectThatItDoesNotCarry) {
  TransmitPdo pdo = transmit_pdo_with_target();
  pdo.set_value(drive_value(0x60FF, 7));
  EXPECT_FALSE(pdo.send_due(pdo_status(0x0237), 0ms));
}

// Values read earlier may be out of date.
TEST(TransmitPdo, ForgetsWhatWasReadWhenItIsNotValid) {
  TransmitPdo pdo = transmit_pdo_with_target();
  pdo.set_value(drive_value(0x607A, 1));
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x80000185), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1800, 1}, 0x185), AbortCode::none);
  EXPECT_FALSE(pdo.send_due(pdo_status(0x0237), 0ms));
  pdo.set_value(drive_value(0x607A, 1));
  EXPECT_TRUE(pdo.send_due(pdo_status(0x0237), 1ms));
}

TEST(TransmitPdo, NeedsNoValueAfterAReset) {
  TransmitPdo pdo = transmit_pdo_with_target();
  pdo.reset();
  EXPECT_TRUE(pdo.send_due(pdo_status(0x0237), 0ms));
}

}  // namespace
}  // namespace vdrive::canopen
