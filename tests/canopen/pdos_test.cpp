// SPDX-License-Identifier: Apache-2.0
#include "node/pdos.hpp"

#include "canopen/pdo_support.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

const Frame kPlainSync = pdo_frame(0x80);

/// PDOs that have been operational since 0, and their recording host.
class PdosTest : public testing::Test {
 protected:
  PdosTest() { restart(); }

  /// Starts the PDOs and clears the host's records.
  void restart(DriveTime now = 0ms) {
    pdos.start(pdo_status(0x0250), now);
    forget();
  }

  void forget() { host = {}; }

  /// Writes an object and expects success.
  void set(ObjectAddress object, std::uint32_t value) {
    EXPECT_EQ(pdos.write(object, value), AbortCode::none) << object.index;
  }

  /// Switches off all TPDOs except the first.
  void keep_the_first_tpdo() {
    set({0x1801, 1}, kCobIdNotValid);
    set({0x1802, 1}, kCobIdNotValid);
    set({0x1803, 1}, kCobIdNotValid);
  }

  [[nodiscard]] std::vector<std::uint32_t> sent_ids() const {
    std::vector<std::uint32_t> ids;
    for (const Frame& frame : host.frames) ids.push_back(frame.id);
    return ids;
  }

  RecordingPdoHost host;
  Pdos pdos{kPdoNode, host, std::nullopt};
};

TEST_F(PdosTest, HaveTheObjectsOfFourPdosEachAndOfSync) {
  for (const std::uint32_t index : {0x1005U, 0x1006U, 0x1007U, 0x1019U, 0x1400U, 0x1403U, 0x1600U,
                                    0x1603U, 0x1800U, 0x1803U, 0x1A00U, 0x1A03U}) {
    EXPECT_TRUE(Pdos::has({static_cast<std::uint16_t>(index), 0})) << index;
  }
  for (const std::uint32_t index : {0x1004U, 0x1008U, 0x1014U, 0x13FFU, 0x1404U, 0x15FFU, 0x1604U,
                                    0x1804U, 0x1A04U, 0x1C00U, 0x6040U}) {
    EXPECT_FALSE(Pdos::has({static_cast<std::uint16_t>(index), 0})) << index;
  }
}

TEST_F(PdosTest, ReadWhatWasWritten) {
  set({0x1402, 5}, 20);
  set({0x1803, 2}, 10);
  set({0x1007, 0}, 500);
  EXPECT_EQ(pdos.read({0x1402, 5}), 20U);
  EXPECT_EQ(pdos.read({0x1400, 5}), 0U);
  EXPECT_EQ(pdos.read({0x1803, 2}), 10U);
  EXPECT_EQ(pdos.read({0x1007, 0}), 500U);
  EXPECT_EQ(pdos.read({0x1A02, 2}), kMapPosition);
}

TEST_F(PdosTest, SendEachEventDrivenTpdoOnceWhenTheyStart) {
  pdos.stop();
  pdos.start(pdo_status(0x0250, 7), 1s);
  ASSERT_THAT(sent_ids(), ElementsAre(0x185U, 0x285U, 0x385U, 0x485U));
  EXPECT_THAT(pdo_bytes(host.frames[2]), ElementsAre(0x50, 0x02, 7, 0, 0, 0));
  pdos.update(pdo_status(0x0250, 7), 2s);
  pdos.advance(3s);
  EXPECT_THAT(host.frames, SizeIs(4));
}

TEST_F(PdosTest, SendChangesOfTheDrive) {
  pdos.update(pdo_status(0x0231), 20ms);
  EXPECT_THAT(sent_ids(), ElementsAre(0x185U, 0x285U, 0x385U, 0x485U));
  forget();
  pdos.update(pdo_status(0x0231, 5), 40ms);  // 6064h is only in TPDO 3
  EXPECT_THAT(sent_ids(), ElementsAre(0x385U));
}

TEST_F(PdosTest, SendAtTheEndOfAnInhibitTime) {
  pdos.update(pdo_status(0x0250, 5), 1ms);  // the default inhibit time ends at 10 ms
  EXPECT_THAT(host.frames, IsEmpty());
  EXPECT_EQ(pdos.next_due(), DriveTime(10ms));
  pdos.advance(9ms);
  EXPECT_THAT(host.frames, IsEmpty());
  pdos.advance(10ms);
  EXPECT_THAT(sent_ids(), ElementsAre(0x385U));
  EXPECT_FALSE(pdos.next_due());
}

TEST_F(PdosTest, PassAnEventDrivenRpdoAtOnce) {
  EXPECT_TRUE(pdos.receive(pdo_frame(0x205, {0x0F, 0x00}), 1ms));
  ASSERT_THAT(host.commands, SizeIs(1));
  EXPECT_THAT(host.commands[0], ElementsAre(drive_value(0x6040, 0x0F)));
}

TEST_F(PdosTest, PassTheControlwordLast) {
  EXPECT_TRUE(pdos.receive(pdo_frame(0x405, {0x1F, 0x00, 0xE8, 0x03, 0x00, 0x00}), 1ms));
  ASSERT_THAT(host.commands, SizeIs(1));
  EXPECT_THAT(host.commands[0], ElementsAre(drive_value(0x607A, 1'000), drive_value(0x6040, 0x1F)));
}

TEST_F(PdosTest, PassSynchronousRpdosTogetherAtSync) {
  for (std::uint16_t index = 0x1400; index <= 0x1403; ++index) set({index, 2}, 1);
  EXPECT_TRUE(pdos.receive(pdo_frame(0x205, {0x06, 0x00}), 1ms));
  EXPECT_TRUE(pdos.receive(pdo_frame(0x305, {0x07, 0x00, 0x08}), 2ms));
  EXPECT_TRUE(pdos.receive(pdo_frame(0x405, {0x0F, 0x00, 0x01, 0x00, 0x00, 0x00}), 3ms));
  EXPECT_THAT(host.commands, IsEmpty());
  EXPECT_TRUE(pdos.receive(kPlainSync, 4ms));
  ASSERT_THAT(host.commands, SizeIs(1));
  EXPECT_THAT(host.commands[0], ElementsAre(drive_value(0x6060, 8), drive_value(0x607A, 1),
                                            drive_value(0x6040, 0x0F)));
  EXPECT_TRUE(pdos.receive(kPlainSync, 5ms));
  EXPECT_THAT(host.commands, SizeIs(1));
}

TEST_F(PdosTest, LetTheLastPdoWinWhateverCameFirst) {
  set({0x1400, 2}, 0);
  set({0x1401, 2}, 240);
  pdos.receive(pdo_frame(0x305, {0x0F, 0x00, 0x01}), 1ms);
  pdos.receive(pdo_frame(0x205, {0x06, 0x00}), 2ms);
  pdos.receive(kPlainSync, 3ms);
  ASSERT_THAT(host.commands, SizeIs(1));
  EXPECT_THAT(host.commands[0], ElementsAre(drive_value(0x6060, 1), drive_value(0x6040, 0x0F)));
}

TEST_F(PdosTest, PassTheFrameThatCameLastBeforeSync) {
  set({0x1400, 2}, 1);
  pdos.receive(pdo_frame(0x205, {0x06, 0x00}), 1ms);
  pdos.receive(pdo_frame(0x205, {0x07, 0x00}), 2ms);
  pdos.receive(kPlainSync, 3ms);
  ASSERT_THAT(host.commands, SizeIs(1));
  EXPECT_THAT(host.commands[0], ElementsAre(drive_value(0x6040, 7)));
}

TEST_F(PdosTest, CommandNothingAtASyncWithoutSetPoints) {
  EXPECT_TRUE(pdos.receive(kPlainSync, 1ms));
  EXPECT_THAT(host.commands, IsEmpty());
}

TEST_F(PdosTest, SendTpdosBeforeTheSetPointsOfASyncAct) {
  keep_the_first_tpdo();
  set({0x1800, 2}, 1);
  set({0x1400, 2}, 1);
  pdos.receive(pdo_frame(0x205, {0x06, 0x00}), 1ms);
  pdos.receive(kPlainSync, 2ms);
  EXPECT_THAT(sent_ids(), ElementsAre(0x185U));
  EXPECT_THAT(host.commands, SizeIs(1));
  EXPECT_EQ(host.commands_before_last_frame, 0U);
}

TEST_F(PdosTest, SendAtSyncWhatTheDriveWasAtTheLastUpdate) {
  keep_the_first_tpdo();
  set({0x1800, 2}, 1);
  pdos.update(pdo_status(0x0231), 1ms);
  pdos.update(pdo_status(0x0233), 2ms);
  EXPECT_THAT(host.frames, IsEmpty());
  pdos.receive(kPlainSync, 3ms);
  pdos.receive(kPlainSync, 4ms);
  ASSERT_THAT(host.frames, SizeIs(2));
  EXPECT_THAT(pdo_bytes(host.frames[0]), ElementsAre(0x33, 0x02));
  EXPECT_EQ(host.frames[1], host.frames[0]);
}

TEST_F(PdosTest, ExchangeNothingAtASyncOfAWrongLength) {
  keep_the_first_tpdo();
  set({0x1800, 2}, 1);
  set({0x1400, 2}, 1);
  pdos.receive(pdo_frame(0x205, {0x06, 0x00}), 1ms);
  EXPECT_TRUE(pdos.receive(pdo_frame(0x80, {1}), 2ms));
  EXPECT_THAT(host.errors, ElementsAre(0x8240));
  EXPECT_THAT(host.frames, IsEmpty());
  EXPECT_THAT(host.commands, IsEmpty());
}

TEST_F(PdosTest, GiveTpdosTheCounterOfSync) {
  keep_the_first_tpdo();
  set({0x1019, 0}, 4);
  set({0x1800, 1}, 0x80000185);
  set({0x1800, 2}, 1);
  set({0x1800, 6}, 2);
  set({0x1800, 1}, 0x185);
  pdos.receive(pdo_frame(0x80, {1}), 1ms);
  EXPECT_THAT(host.frames, IsEmpty());
  pdos.receive(pdo_frame(0x80, {2}), 2ms);
  EXPECT_THAT(sent_ids(), ElementsAre(0x185U));
}

TEST_F(PdosTest, DropAndCountAnRpdoThatIsTooShort) {
  EXPECT_TRUE(pdos.receive(pdo_frame(0x305, {0x06, 0x00}), 1ms));
  EXPECT_THAT(host.errors, ElementsAre(0x8210));
  EXPECT_THAT(host.commands, IsEmpty());
  EXPECT_EQ(pdos.counters().dropped, 1U);
}

TEST_F(PdosTest, UseAnRpdoThatIsTooLong) {
  EXPECT_TRUE(pdos.receive(pdo_frame(0x205, {0x06, 0x00, 0x00}), 1ms));
  EXPECT_THAT(host.errors, ElementsAre(0x8220));
  EXPECT_THAT(host.commands, SizeIs(1));
  EXPECT_EQ(pdos.counters().dropped, 0U);
}

TEST_F(PdosTest, DropAndCountSynchronousRpdosAfterTheWindow) {
  set({0x1400, 2}, 1);
  set({0x1007, 0}, 2'000);
  pdos.receive(kPlainSync, 10ms);
  pdos.receive(pdo_frame(0x205, {0x06, 0x00}), 12ms);
  pdos.receive(pdo_frame(0x205, {0x07, 0x00}), 13ms);        // 3 ms: too late
  pdos.receive(pdo_frame(0x305, {0x0F, 0x00, 0x01}), 13ms);  // event-driven: no window
  EXPECT_EQ(pdos.counters().dropped, 1U);
  EXPECT_THAT(host.commands, SizeIs(1));
  pdos.receive(kPlainSync, 20ms);
  ASSERT_THAT(host.commands, SizeIs(2));
  EXPECT_THAT(host.commands[1], ElementsAre(drive_value(0x6040, 6)));
}

TEST_F(PdosTest, RaiseTheTimeOutOfAnRpdoOnce) {
  set({0x1401, 5}, 30);
  pdos.receive(pdo_frame(0x305, {0x06, 0x00, 0x01}), 100ms);
  EXPECT_EQ(pdos.next_due(), DriveTime(130ms));
  pdos.advance(129ms);
  EXPECT_THAT(host.errors, IsEmpty());
  pdos.advance(130ms);
  pdos.advance(200ms);
  EXPECT_THAT(host.errors, ElementsAre(0x8250));
  EXPECT_FALSE(pdos.next_due());
}

TEST_F(PdosTest, AreDueWhenTheFirstOfThemIs) {
  set({0x1801, 5}, 70);
  set({0x1800, 5}, 50);
  set({0x1401, 5}, 30);
  EXPECT_EQ(pdos.next_due(), DriveTime(50ms));
  pdos.receive(pdo_frame(0x305, {0x06, 0x00, 0x01}), 10ms);
  EXPECT_EQ(pdos.next_due(), DriveTime(40ms));
}

TEST_F(PdosTest, IgnoreRemoteFramesForRpdosAndSync) {
  EXPECT_FALSE(pdos.receive(pdo_request(0x205), 1ms));
  EXPECT_FALSE(pdos.receive(pdo_request(0x80), 1ms));
  EXPECT_THAT(host.commands, IsEmpty());
  EXPECT_EQ(pdos.counters().dropped, 0U);
}

TEST_F(PdosTest, IgnoreExtendedFramesAndOtherIdentifiers) {
  Frame extended = pdo_frame(0x205, {0x06, 0x00});
  extended.is_extended = true;
  EXPECT_FALSE(pdos.receive(extended, 1ms));
  EXPECT_FALSE(pdos.receive(pdo_frame(0x206, {0x06, 0x00}), 1ms));
  EXPECT_FALSE(pdos.receive(pdo_frame(0x185, {0x06, 0x00}), 1ms));  // one of its own TPDOs
  EXPECT_FALSE(pdos.receive(pdo_frame(0x605, {0x40}), 1ms));
  EXPECT_THAT(host.commands, IsEmpty());
}

TEST_F(PdosTest, AnswerRemoteFramesForATpdoThatAllowsThem) {
  set({0x1800, 1}, 0x00000185);
  EXPECT_TRUE(pdos.receive(pdo_request(0x185), 1ms));
  ASSERT_THAT(sent_ids(), ElementsAre(0x185U));
  EXPECT_THAT(pdo_bytes(host.frames[0]), ElementsAre(0x50, 0x02));
  set({0x1800, 1}, 0x40000185);
  EXPECT_FALSE(pdos.receive(pdo_request(0x185), 2ms));
  EXPECT_THAT(host.frames, SizeIs(1));
}

TEST_F(PdosTest, ExchangeNothingBeforeTheyStart) {
  RecordingPdoHost silent;
  Pdos idle(kPdoNode, silent, std::nullopt);
  idle.update(pdo_status(0x0231), 1ms);
  idle.advance(2ms);
  EXPECT_TRUE(idle.receive(kPlainSync, 3ms));
  EXPECT_TRUE(idle.receive(pdo_frame(0x80, {1}), 3ms));
  EXPECT_TRUE(idle.receive(pdo_frame(0x205, {0x06, 0x00}), 4ms));
  EXPECT_EQ(idle.write({0x1800, 1}, 0x185), AbortCode::none);
  EXPECT_TRUE(idle.receive(pdo_request(0x185), 5ms));
  EXPECT_THAT(silent.frames, IsEmpty());
  EXPECT_THAT(silent.commands, IsEmpty());
  EXPECT_THAT(silent.errors, IsEmpty());
  EXPECT_EQ(idle.counters().dropped, 1U);
  EXPECT_FALSE(idle.next_due());
}

TEST_F(PdosTest, ForgetWhatWaitsWhenTheyStop) {
  set({0x1400, 2}, 1);
  set({0x1401, 5}, 30);
  pdos.receive(pdo_frame(0x205, {0x06, 0x00}), 1ms);
  pdos.receive(pdo_frame(0x305, {0x06, 0x00, 0x01}), 1ms);
  pdos.stop();
  EXPECT_FALSE(pdos.next_due());
  restart(10ms);
  pdos.receive(kPlainSync, 20ms);
  pdos.advance(100ms);
  EXPECT_THAT(host.commands, IsEmpty());
  EXPECT_THAT(host.errors, IsEmpty());
}

TEST_F(PdosTest, KeepTheirObjectsWhenTheyStop) {
  set({0x1400, 2}, 1);
  pdos.stop();
  EXPECT_EQ(pdos.read({0x1400, 2}), 1U);
}

TEST_F(PdosTest, HaveTheirDefaultsAndAreStoppedAfterAReset) {
  set({0x1400, 2}, 1);
  set({0x1800, 1}, kCobIdNotValid);
  set({0x1005, 0}, 0x100);
  pdos.reset();
  EXPECT_EQ(pdos.read({0x1400, 2}), 255U);
  EXPECT_EQ(can_id_of(pdos.read({0x1800, 1})), 0x185U);
  EXPECT_EQ(pdos.read({0x1005, 0}), 0x80U);
  pdos.update(pdo_status(0x0231), 50ms);
  EXPECT_TRUE(pdos.receive(pdo_frame(0x205, {0x06, 0x00}), 50ms));
  EXPECT_THAT(host.frames, IsEmpty());
  EXPECT_THAT(host.commands, IsEmpty());
}

TEST_F(PdosTest, CarryWhatAMasterRemapsThemTo) {
  remap_pdo(pdos, 0x1400, {kMapControlword, kMapTargetPosition, kMapMode});
  remap_pdo(pdos, 0x1800, {kMapStatusword, kMapPosition, kMapModeDisplay});
  pdos.receive(pdo_frame(0x205, {0x0F, 0x00, 0xFF, 0xFF, 0xFF, 0xFF, 0x08}), 1ms);
  ASSERT_THAT(host.commands, SizeIs(1));
  EXPECT_THAT(host.commands[0], ElementsAre(drive_value(0x607A, -1), drive_value(0x6060, 8),
                                            drive_value(0x6040, 0x0F)));
  AxisStatus drive = pdo_status(0x0250, -3);
  drive.op_mode_actual = 8;
  pdos.update(drive, 100ms);
  ASSERT_FALSE(host.frames.empty());
  EXPECT_THAT(pdo_bytes(host.frames[0]), ElementsAre(0x50, 0x02, 0xFD, 0xFF, 0xFF, 0xFF, 8));
}

TEST_F(PdosTest, HaveAValueReadOnceForAllTpdosThatCarryIt) {
  remap_pdo(pdos, 0x1800, {kMapTargetPosition});
  remap_pdo(pdos, 0x1801, {kMapMode, kMapTargetPosition});
  EXPECT_THAT(pdos.read_objects(), ElementsAre(ObjectAddress{0x607A, 0}, ObjectAddress{0x6060, 0}));
  forget();
  pdos.set_value(drive_value(0x607A, -3));
  pdos.set_value(drive_value(0x6060, 8));
  EXPECT_TRUE(host.frames.empty()) << "it goes out with a tick";
  pdos.update(pdo_status(0x0250), 1ms);
  ASSERT_THAT(host.frames, SizeIs(2));
  EXPECT_THAT(pdo_bytes(host.frames[0]), ElementsAre(0xFD, 0xFF, 0xFF, 0xFF));
  EXPECT_THAT(pdo_bytes(host.frames[1]), ElementsAre(8, 0xFD, 0xFF, 0xFF, 0xFF));
}

TEST_F(PdosTest, SendATpdoThatBecomesValidInOperation) {
  set({0x1800, 1}, 0x80000185);
  EXPECT_FALSE(pdos.next_due());
  set({0x1800, 1}, 0x185);
  EXPECT_EQ(pdos.next_due(), DriveTime::zero());  // immediately
  pdos.advance(5ms);
  EXPECT_THAT(sent_ids(), ElementsAre(0x185U));
  EXPECT_FALSE(pdos.next_due());
}

TEST_F(PdosTest, PassAFrameToEachRpdoWithItsCanId) {
  set({0x1401, 1}, kCobIdNotValid);
  set({0x1401, 1}, 0x205);
  pdos.receive(pdo_frame(0x205, {0x06, 0x00, 0x01}), 1ms);
  ASSERT_THAT(host.commands, SizeIs(2));
  EXPECT_THAT(host.commands[0], ElementsAre(drive_value(0x6040, 6)));
  EXPECT_THAT(host.commands[1], ElementsAre(drive_value(0x6060, 1), drive_value(0x6040, 6)));
  EXPECT_THAT(host.errors, ElementsAre(0x8220));  // RPDO 1 has two bytes
}

TEST_F(PdosTest, CommandNothingByAnRpdoOfDummies) {
  remap_pdo(pdos, 0x1400, {map_entry(0x0007, 0, 32)});
  EXPECT_TRUE(pdos.receive(pdo_frame(0x205, {1, 2, 3, 4}), 1ms));
  EXPECT_THAT(host.commands, IsEmpty());
  EXPECT_EQ(pdos.counters().dropped, 0U);
}

TEST_F(PdosTest, LatchASyncThatIsAnRpdoForTheNextOne) {
  set({0x1400, 1}, kCobIdNotValid);
  set({0x1400, 1}, 0x80);
  set({0x1400, 2}, 1);
  remap_pdo(pdos, 0x1400, {kMapMode});
  set({0x1019, 0}, 10);
  pdos.receive(pdo_frame(0x80, {1}), 1ms);
  EXPECT_THAT(host.commands, IsEmpty());
  pdos.receive(pdo_frame(0x80, {2}), 2ms);
  ASSERT_THAT(host.commands, SizeIs(1));
  EXPECT_THAT(host.commands[0], ElementsAre(drive_value(0x6060, 1)));
}

}  // namespace
}  // namespace vdrive::canopen
