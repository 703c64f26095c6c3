// SPDX-License-Identifier: Apache-2.0
#include "node/receive_pdo.hpp"

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

/// The first RPDO of the node with these mapped objects.
ReceivePdo receive_pdo_with(const std::vector<std::uint32_t>& entries) {
  ReceivePdo pdo(pdo_place(1));
  remap_pdo(pdo, 0x1400, entries);
  return pdo;
}

std::vector<DriveValue> listed(const SetPoints& set_points) {
  const auto values = set_points.values();
  return {values.begin(), values.end()};
}

std::vector<DriveValue> taken_from(ReceivePdo& pdo) {
  SetPoints set_points;
  pdo.take(set_points);
  return listed(set_points);
}

/// @return the values that `pdo` extracts from these bytes.
std::vector<DriveValue> received_values(ReceivePdo& pdo, const std::vector<std::uint8_t>& bytes) {
  EXPECT_FALSE(pdo.receive(pdo_frame(0x205, bytes), 0ms).is_dropped);
  return taken_from(pdo);
}

TEST(ReceivePdo, HasTheCanIdOfThePredefinedConnectionSet) {
  // RPDO 1 to 4: 200h, 300h, 400h, 500h + node id
  EXPECT_EQ(can_id_of(ReceivePdo(pdo_place(1)).read({0x1400, 1})), 0x205U);
  EXPECT_EQ(can_id_of(ReceivePdo(pdo_place(2)).read({0x1401, 1})), 0x305U);
  EXPECT_EQ(can_id_of(ReceivePdo(pdo_place(3)).read({0x1402, 1})), 0x405U);
  EXPECT_EQ(can_id_of(ReceivePdo(pdo_place(4)).read({0x1403, 1})), 0x505U);
}

TEST(ReceivePdo, RefusesAnotherCanIdWhileItIsValidWith06090030) {
  ReceivePdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x206), AbortCode::value_range_exceeded);
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x205), AbortCode::none);
  EXPECT_EQ(pdo.read({0x1400, 1}), 0x205U);
}

TEST(ReceivePdo, TakesAnotherCanIdOverNotValid) {
  ReceivePdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x80000206), AbortCode::none);
  EXPECT_FALSE(pdo.awaits(pdo_frame(0x206)));
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x206), AbortCode::none);
  EXPECT_TRUE(pdo.awaits(pdo_frame(0x206)));
  EXPECT_FALSE(pdo.awaits(pdo_frame(0x205)));
}

TEST(ReceivePdo, IsSwitchedOffWithAnyCanId) {
  ReceivePdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x80000000), AbortCode::none);
  EXPECT_EQ(pdo.read({0x1400, 1}), 0x80000000U);
  EXPECT_FALSE(pdo.awaits(pdo_frame(0)));
}

TEST(ReceivePdo, RefusesRestrictedCanIdsWith06090030) {
  ReceivePdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1400, 1}, kCobIdNotValid), AbortCode::none);
  // The bounds of each row of CiA 301, table "Restricted CAN-IDs"
  for (const std::uint32_t can_id : {0x000U, 0x001U, 0x07FU, 0x101U, 0x180U, 0x581U, 0x5FFU, 0x601U,
                                     0x67FU, 0x6E0U, 0x6FFU, 0x701U, 0x77FU, 0x780U, 0x7FFU}) {
    EXPECT_EQ(pdo.write({0x1400, 1}, can_id), AbortCode::value_range_exceeded) << can_id;
  }
  EXPECT_EQ(pdo.read({0x1400, 1}), kCobIdNotValid);
}

TEST(ReceivePdo, TakesTheCanIdsThatAreNotRestricted) {
  for (const std::uint32_t can_id :
       {0x080U, 0x100U, 0x181U, 0x57FU, 0x580U, 0x600U, 0x680U, 0x6DFU, 0x700U}) {
    ReceivePdo pdo(pdo_place(1));
    EXPECT_EQ(pdo.write({0x1400, 1}, kCobIdNotValid), AbortCode::none);
    EXPECT_EQ(pdo.write({0x1400, 1}, can_id), AbortCode::none) << can_id;
  }
}

TEST(ReceivePdo, RefusesTheExtendedFormatWith06090030) {
  ReceivePdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x20000205), AbortCode::value_range_exceeded);
  EXPECT_EQ(pdo.write({0x1400, 1}, 0xA0000205), AbortCode::value_range_exceeded);
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x80000A05), AbortCode::value_range_exceeded);  // bit 11
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x90000205), AbortCode::value_range_exceeded);  // bit 28
}

TEST(ReceivePdo, DoesNotBecomeValidWithoutAMappedObject) {
  ReceivePdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x80000205), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1600, 0}, 0), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x205), AbortCode::value_range_exceeded);
  EXPECT_EQ(pdo.write({0x1600, 0}, 1), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x205), AbortCode::none);
}

TEST(ReceivePdo, KeepsBit30WhichHasNoMeaning) {
  ReceivePdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x40000205), AbortCode::none);
  EXPECT_EQ(pdo.read({0x1400, 1}), 0x40000205U);
  EXPECT_TRUE(pdo.awaits(pdo_frame(0x205)));
}

TEST(ReceivePdo, TakesSynchronousAndEventDrivenTypes) {
  ReceivePdo pdo(pdo_place(1));
  for (std::uint32_t type = 0; type <= 300; ++type) {
    const bool is_known = type <= 240 || type == 254 || type == 255;
    EXPECT_EQ(pdo.write({0x1400, 2}, type),
              is_known ? AbortCode::none : AbortCode::value_range_exceeded)
        << type;
    if (is_known) {
      EXPECT_EQ(pdo.is_synchronous(), type <= 240) << type;
    }
  }
}

TEST(ReceivePdo, HasNeitherAWritableCountNorAReservedObject) {
  ReceivePdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1400, 0}, 6), AbortCode::write_of_read_only_object);
  EXPECT_EQ(pdo.write({0x1400, 4}, 0), AbortCode::subindex_does_not_exist);
  EXPECT_EQ(pdo.write({0x1400, 7}, 0), AbortCode::subindex_does_not_exist);
}

TEST(ReceivePdo, GivesLittleEndianNumbersTheirSign) {
  ReceivePdo pdo = receive_pdo_with({kMapMode, kMapTargetTorque, kMapTargetPosition});
  // INTEGER8 FFh = -1; INTEGER16 FFFEh = -2; INTEGER32 80000000h = -2^31
  EXPECT_THAT(received_values(pdo, {0xFF, 0xFE, 0xFF, 0x00, 0x00, 0x00, 0x80}),
              ElementsAre(drive_value(0x6060, -1), drive_value(0x6071, -2),
                          drive_value(0x607A, -2'147'483'648)));
}

TEST(ReceivePdo, GivesUnsignedNumbersNoSign) {
  ReceivePdo pdo = receive_pdo_with({kMapProfileVelocity, kMapControlword});
  EXPECT_THAT(received_values(pdo, {0xFF, 0xFF, 0xFF, 0xFF, 0xFE, 0xFF}),
              ElementsAre(drive_value(0x6081, 4'294'967'295), drive_value(0x6040, 0xFFFE)));
}

TEST(ReceivePdo, SkipsTheBytesOfDummies) {
  ReceivePdo pdo =
      receive_pdo_with({map_entry(0x0006, 0, 16), kMapTargetPosition, map_entry(0x0005, 0, 8)});
  EXPECT_THAT(received_values(pdo, {0xAA, 0xBB, 0x01, 0x02, 0x00, 0x00, 0xCC}),
              ElementsAre(drive_value(0x607A, 0x0201)));
}

TEST(ReceivePdo, DropsAFrameThatIsTooShortWith8210) {
  ReceivePdo pdo = receive_pdo_with({kMapControlword, kMapMode});
  const PdoReception reception = pdo.receive(pdo_frame(0x205, {0x0F, 0x00}), 0ms);
  EXPECT_TRUE(reception.is_dropped);
  EXPECT_EQ(reception.error_code, 0x8210);
  EXPECT_THAT(taken_from(pdo), IsEmpty());
}

TEST(ReceivePdo, UsesTheFirstBytesOfAFrameThatIsTooLongWith8220) {
  ReceivePdo pdo = receive_pdo_with({kMapControlword});
  const PdoReception reception = pdo.receive(pdo_frame(0x205, {0x0F, 0x00, 0x55}), 0ms);
  EXPECT_FALSE(reception.is_dropped);
  EXPECT_EQ(reception.error_code, 0x8220);
  EXPECT_THAT(taken_from(pdo), ElementsAre(drive_value(0x6040, 0x0F)));
}

TEST(ReceivePdo, RaisesAnErrorOfTheLengthOnceUntilTheLengthIsRight) {
  ReceivePdo pdo = receive_pdo_with({kMapControlword});
  const Frame too_short = pdo_frame(0x205, {0x0F});
  EXPECT_EQ(pdo.receive(too_short, 0ms).error_code, 0x8210);
  EXPECT_EQ(pdo.receive(too_short, 1ms).error_code, 0);
  EXPECT_TRUE(pdo.receive(too_short, 2ms).is_dropped);
  EXPECT_EQ(pdo.receive(pdo_frame(0x205, {0x0F, 0x00, 0x00}), 3ms).error_code, 0x8220);
  EXPECT_EQ(pdo.receive(pdo_frame(0x205, {0x0F, 0x00}), 4ms).error_code, 0);
  EXPECT_EQ(pdo.receive(too_short, 5ms).error_code, 0x8210);
}

TEST(ReceivePdo, AwaitsOnlyDataFramesInTheBaseFormat) {
  const ReceivePdo pdo(pdo_place(1));
  EXPECT_TRUE(pdo.awaits(pdo_frame(0x205)));
  EXPECT_FALSE(pdo.awaits(pdo_frame(0x206)));
  EXPECT_FALSE(pdo.awaits(pdo_request(0x205)));
  Frame extended = pdo_frame(0x205);
  extended.is_extended = true;
  EXPECT_FALSE(pdo.awaits(extended));
}

TEST(ReceivePdo, GivesTheFrameThatCameLastOnce) {
  ReceivePdo pdo = receive_pdo_with({kMapControlword});
  pdo.receive(pdo_frame(0x205, {0x06, 0x00}), 0ms);
  pdo.receive(pdo_frame(0x205, {0x07, 0x00}), 1ms);
  EXPECT_THAT(taken_from(pdo), ElementsAre(drive_value(0x6040, 7)));
  EXPECT_THAT(taken_from(pdo), IsEmpty());
}

TEST(ReceivePdo, TimesOutOnceWhenItsEventTimerHasElapsed) {
  ReceivePdo pdo = receive_pdo_with({kMapControlword});
  EXPECT_EQ(pdo.write({0x1400, 5}, 50), AbortCode::none);
  EXPECT_FALSE(pdo.next_due());  // starts with the first frame
  EXPECT_FALSE(pdo.times_out(1s));
  pdo.receive(pdo_frame(0x205, {0x06, 0x00}), 1'010ms);
  EXPECT_EQ(pdo.next_due(), DriveTime(1'060ms));
  EXPECT_FALSE(pdo.times_out(1'059'999us));
  EXPECT_TRUE(pdo.times_out(1'060ms));
  EXPECT_FALSE(pdo.times_out(1'061ms));
  EXPECT_FALSE(pdo.next_due());
}

TEST(ReceivePdo, TimesOutLaterWithEachFrame) {
  ReceivePdo pdo = receive_pdo_with({kMapControlword});
  EXPECT_EQ(pdo.write({0x1400, 5}, 50), AbortCode::none);
  pdo.receive(pdo_frame(0x205, {0x06, 0x00}), 0ms);
  pdo.receive(pdo_frame(0x205, {0x06, 0x00}), 40ms);
  EXPECT_FALSE(pdo.times_out(89ms));
  EXPECT_TRUE(pdo.times_out(90ms));
  pdo.receive(pdo_frame(0x205, {0x06, 0x00}), 100ms);
  EXPECT_TRUE(pdo.times_out(150ms));
}

TEST(ReceivePdo, DoesNotTimeOutLaterWithAFrameThatIsTooShort) {
  ReceivePdo pdo = receive_pdo_with({kMapControlword});
  EXPECT_EQ(pdo.write({0x1400, 5}, 50), AbortCode::none);
  pdo.receive(pdo_frame(0x205, {0x06, 0x00}), 0ms);
  pdo.receive(pdo_frame(0x205, {0x06}), 40ms);
  EXPECT_TRUE(pdo.times_out(50ms));
}

TEST(ReceivePdo, BeginsItsTimeOutAgainAfterAnotherEventTimer) {
  ReceivePdo pdo = receive_pdo_with({kMapControlword});
  EXPECT_EQ(pdo.write({0x1400, 5}, 50), AbortCode::none);
  pdo.receive(pdo_frame(0x205, {0x06, 0x00}), 0ms);
  EXPECT_EQ(pdo.write({0x1400, 5}, 20), AbortCode::none);
  EXPECT_FALSE(pdo.next_due());
  pdo.receive(pdo_frame(0x205, {0x06, 0x00}), 30ms);
  EXPECT_EQ(pdo.next_due(), DriveTime(50ms));
}

TEST(ReceivePdo, RefusesAnEventTimerAbove16Bits) {
  ReceivePdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1400, 5}, 0x10000), AbortCode::value_range_exceeded);
  EXPECT_EQ(pdo.write({0x1400, 5}, 0xFFFF), AbortCode::none);
}

TEST(ReceivePdo, ForgetsItsFrameWhenItIsSwitchedOff) {
  ReceivePdo pdo(pdo_place(1));
  pdo.receive(pdo_frame(0x205, {0x06, 0x00}), 0ms);
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x80000205), AbortCode::none);
  EXPECT_EQ(pdo.write({0x1400, 1}, 0x205), AbortCode::none);
  EXPECT_THAT(taken_from(pdo), IsEmpty());
}

TEST(ReceivePdo, ForgetsItsFrameWithAnotherTransmissionType) {
  ReceivePdo pdo(pdo_place(1));
  EXPECT_EQ(pdo.write({0x1400, 2}, 1), AbortCode::none);
  pdo.receive(pdo_frame(0x205, {0x06, 0x00}), 0ms);
  EXPECT_EQ(pdo.write({0x1400, 2}, 1), AbortCode::none);  // unchanged
  EXPECT_EQ(pdo.write({0x1400, 2}, 255), AbortCode::none);
  EXPECT_THAT(taken_from(pdo), IsEmpty());
}

TEST(SetPoints, HasEachObjectOnceWithItsLastValue) {
  SetPoints set_points;
  set_points.put(drive_value(0x607A, 1));
  set_points.put(drive_value(0x60FF, 2));
  set_points.put(drive_value(0x607A, 3));
  EXPECT_THAT(listed(set_points), ElementsAre(drive_value(0x60FF, 2), drive_value(0x607A, 3)));
}

TEST(SetPoints, HasTheControlwordLast) {
  SetPoints set_points;
  set_points.put(drive_value(0x6040, 0x0F));
  set_points.put(drive_value(0x607A, 1));
  set_points.put(drive_value(0x6040, 0x1F));
  set_points.put(drive_value(0x6060, 8));
  EXPECT_THAT(listed(set_points), ElementsAre(drive_value(0x607A, 1), drive_value(0x6060, 8),
                                              drive_value(0x6040, 0x1F)));
}

}  // namespace
}  // namespace vdrive::canopen
