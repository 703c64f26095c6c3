// SPDX-License-Identifier: Apache-2.0
// The bridge with a bench in lock-step, on which each SYNC lets one period pass.
#include "canopen/bus_of_bench.hpp"
#include "canopen/tcp_peer.hpp"
#include "node/node_object.hpp"
#include "support/temporary_directory.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using canopen::Frame;
using canopen::NmtState;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr ObjectAddress kControlword{0x6040, 0};
constexpr ObjectAddress kMode{0x6060, 0};
constexpr ObjectAddress kTarget{0x607A, 0};
constexpr ObjectAddress kPosition{0x6064, 0};

constexpr std::array<std::uint8_t, 3> kEnablingWords{0x06, 0x07, 0x0F};

constexpr std::uint8_t kStart = 0x01;  // NMT commands
constexpr std::uint8_t kResetNode = 0x81;

/// Enables the axis by SDO, one controlword per SYNC.
void enable_by_sdo(BusOfBench& bus, std::uint8_t node) {
  for (const std::uint8_t word : kEnablingWords) {
    ASSERT_EQ(bus.master().download(node, kControlword, word, 2), AbortCode::none);
    bus.sync();
  }
  ASSERT_EQ(bus.statusword(node) & kStateBits, kShowsEnabled);
}

/// @return the tick of the bench. Reading it lets no time pass.
std::uint64_t tick_of(BusOfBench& bus) {
  client::Session session = bus.other_session();
  return session.axis("1.1").value().status().value().tick;
}

TEST(SteppedBridge, BootsANodeForEachAxis) {
  BusOfBench bus(3, 1ms);
  std::vector<std::uint32_t> ids;
  for (const Frame& frame : bus.master().received()) {
    if (frame.size == 1 && frame.data[0] == 0x00) ids.push_back(frame.id);
  }
  EXPECT_THAT(ids, ElementsAre(0x701U, 0x702U, 0x703U));
  EXPECT_EQ(bus.nodes().node(2)->state(), NmtState::pre_operational);
}

TEST(SteppedBridge, AnswersEveryObjectOfTheDictionaryByItsAccessAndSize) {
  BusOfBench bus(1, 1ms);
  for (const canopen::NodeObject& object : canopen::node_objects()) {
    const auto answer = bus.master().upload(1, object.address);
    const std::string name = address_text(object.address);
    if (object.access == canopen::NodeAccess::write_only) {
      EXPECT_EQ(answer.abort, AbortCode::read_of_write_only_object) << name;
      continue;
    }
    // The error history of a drive without faults is empty.
    const bool is_empty = object.address.index == 0x1003 && object.address.subindex > 0;
    EXPECT_EQ(answer.abort, is_empty ? AbortCode::no_data_available : AbortCode::none) << name;
    if (is_empty) continue;
    const std::size_t size = canopen::size_of(object.data_type);
    if (size != 0) {
      EXPECT_EQ(answer.data.size(), size) << name;
    }
  }
  EXPECT_EQ(bus.master().upload(1, {0x1234, 0}).abort, AbortCode::object_does_not_exist);
  EXPECT_EQ(bus.master().upload(1, {0x607D, 9}).abort, AbortCode::subindex_does_not_exist);
}

// Writes each object's current value, which every drive accepts.
TEST(SteppedBridge, TakesEveryWritableObjectOfTheDriveAndRefusesTheOthers) {
  BusOfBench bus(1, 1ms);
  for (const ObjectDescription& object : kObjectTable) {
    const std::string name = address_text(object.address);
    const std::size_t size = size_of(object.data_type);
    if (object.access == Access::read_only) {
      EXPECT_EQ(bus.master().download(1, object.address, 0, size),
                AbortCode::write_of_read_only_object)
          << name;
    } else if (object.change != Change::memory) {
      const bool is_written_only =
          canopen::find_node_object(object.address)->access == canopen::NodeAccess::write_only;
      const std::int64_t value = is_written_only
                                     ? object.default_value
                                     : bus.read(1, object.address, object.lower_limit < 0);
      EXPECT_EQ(bus.master().download(1, object.address, value, size), AbortCode::none) << name;
    }
  }
}

TEST(SteppedBridge, LetsAMasterMeetTheHabitsOfADrive) {
  BusOfBench bus(1, 1ms);
  ASSERT_EQ(bus.master().download(1, {0x5E20, 7}, 20, 2), AbortCode::none);  // power on: 20 ms
  for (const std::uint8_t word : kEnablingWords) {
    ASSERT_EQ(bus.master().download(1, kControlword, word, 2), AbortCode::none);
    bus.sync();
  }
  EXPECT_EQ(bus.statusword(1) & 0x6F, 0x23) << "Switched on";
  bus.sync(30);
  EXPECT_EQ(bus.statusword(1) & kStateBits, kShowsEnabled);
  ASSERT_EQ(bus.master().download(1, {0x5E20, 5}, 2, 1), AbortCode::none);  // no mode change now
  EXPECT_EQ(bus.master().download(1, kMode, 3, 1), AbortCode::refused_in_present_device_state);
  EXPECT_EQ(bus.master().download(1, {0x5E20, 12}, 1, 2), AbortCode::value_range_exceeded);
}

// Each controlword runs the power state machine, even when several arrive before one SYNC.
TEST(SteppedBridge, TakesEveryControlwordThatCameBeforeSync) {
  BusOfBench bus(1, 1ms);
  bus.master().send_nmt(kStart, 1);
  for (const std::uint8_t word : kEnablingWords) bus.master().send(0x201, {word, 0});
  bus.sync();
  EXPECT_EQ(bus.statusword(1) & kStateBits, kShowsEnabled);
}

// Habit f of docs/guides/be-another-drive.md: a controlword loop of 4 ms. 8 SYNC periods are two
// loops.
TEST(SteppedBridge, LeavesTheLastWordBeforeSyncToADriveThatLooksSeldom) {
  BusOfBench bus(1, 1ms);
  TestMaster& master = bus.master();
  master.send_nmt(kStart, 1);
  ASSERT_EQ(master.download(1, {0x5E20, 6}, 4, 2), AbortCode::none);
  ASSERT_EQ(master.download(1, kMode, 1, 1), AbortCode::none);
  ASSERT_EQ(master.download(1, kTarget, 1000, 4), AbortCode::none);
  master.send(0x201, {0x06, 0});
  master.send(0x201, {0x07, 0});
  bus.sync(8);
  EXPECT_EQ(bus.statusword(1) & kStateBits, 0x40) << "0007h in Switch on disabled does nothing";
  for (const std::uint8_t word : kEnablingWords) {
    master.send(0x201, {word, 0});
    bus.sync(8);
  }
  EXPECT_EQ(bus.statusword(1) & kStateBits, kShowsEnabled);
  master.send(0x201, {0x1F, 0});
  master.send(0x201, {0x0F, 0});
  bus.sync(8);
  EXPECT_EQ(bus.statusword(1) & kShowsAcknowledge, 0) << "nobody has seen bit 4";
  EXPECT_EQ(bus.read(1, {0x6062, 0}, true), 0);
  master.send(0x201, {0x1F, 0});
  bus.sync(8);
  EXPECT_NE(bus.statusword(1) & kShowsAcknowledge, 0);
  bus.sync(8);
  EXPECT_GT(bus.read(1, {0x6062, 0}, true), 0);
}

// Habit f: the words last one SYNC period each and follow each other after 13 periods. So each
// begins one period later within the loop of 4, and the drive sees one of four.
TEST(SteppedBridge, LosesThreeOfFourWordsThatLastOneSyncOfALoopOfFour) {
  BusOfBench bus(1, 1ms);
  TestMaster& master = bus.master();
  master.send_nmt(kStart, 1);
  ASSERT_EQ(master.download(1, {0x5E20, 6}, 4, 2), AbortCode::none);
  int seen = 0;
  for (int pulse = 0; pulse < 4; ++pulse) {
    master.send(0x201, {0x06, 0});
    bus.sync();
    if ((bus.statusword(1) & kStateBits) == 0x21) ++seen;
    master.send(0x201, {0x00, 0});
    bus.sync(12);
    EXPECT_EQ(bus.statusword(1) & kStateBits, 0x40) << pulse;
  }
  EXPECT_EQ(seen, 1);
}

TEST(SteppedBridge, MovesInProfilePositionBySdo) {
  BusOfBench bus(1, 1ms);
  ASSERT_EQ(bus.master().download(1, kMode, 1, 1), AbortCode::none);
  ASSERT_NO_FATAL_FAILURE(enable_by_sdo(bus, 1));
  ASSERT_EQ(bus.master().download(1, kTarget, 1000, 4), AbortCode::none);
  ASSERT_EQ(bus.master().download(1, kControlword, 0x1F, 2), AbortCode::none);
  bus.sync();
  EXPECT_NE(bus.statusword(1) & kShowsAcknowledge, 0);
  ASSERT_EQ(bus.master().download(1, kControlword, 0x0F, 2), AbortCode::none);
  int periods = 0;
  do {
    bus.sync();
  } while ((bus.statusword(1) & kShowsTargetReached) == 0 && ++periods < 10'000);
  EXPECT_EQ(bus.read(1, kPosition, true), 1000);
}

// RPDOs received before SYNC n act at n; TPDOs carry the values sampled at n, before the RPDOs act.
TEST(SteppedBridge, StreamsPositionsBySync) {
  BusOfBench bus(1, 1ms);
  TestMaster& master = bus.master();
  constexpr std::array<std::uint16_t, 2> kPdos{0x1402, 0x1802};
  for (const std::uint16_t pdo : kPdos) {
    const std::int64_t id = pdo == 0x1402 ? 0x401 : 0x381;
    ASSERT_EQ(master.download(1, {pdo, 1}, 0x80000000 | id, 4), AbortCode::none);
    ASSERT_EQ(master.download(1, {pdo, 2}, 1, 1), AbortCode::none);
    ASSERT_EQ(master.download(1, {pdo, 1}, id, 4), AbortCode::none);
  }
  ASSERT_EQ(master.download(1, kMode, 8, 1), AbortCode::none);
  ASSERT_NO_FATAL_FAILURE(enable_by_sdo(bus, 1));
  master.send_nmt(kStart, 1);
  const std::int64_t begin = bus.read(1, kPosition, true);
  for (std::int64_t step = 1; step <= 20; ++step) {
    const std::int64_t target = begin + 2 * step;
    std::vector<std::uint8_t> data{0x0F, 0x00};
    for (const std::uint8_t byte : little_endian(target, 4)) data.push_back(byte);
    const std::int64_t before = bus.read(1, kPosition, true);
    (void)master.take_all();
    master.send(0x401, data);
    EXPECT_EQ(master.count(0x381), 0U) << "synchronous";
    bus.sync();
    const auto sampled = master.newest(0x381);
    ASSERT_TRUE(sampled);
    EXPECT_EQ(master.count(0x381), 1U);
    EXPECT_EQ(number_in(*sampled, 2, 4, true), before);
    EXPECT_EQ(bus.read(1, {0x6062, 0}, true), target) << "the demand of the tick behind SYNC";
  }
}

/// A set-point that an RPDO carries along with the controlword, and the object that shows its
/// effect.
struct StreamRow {
  const char* name;
  std::int64_t mode;
  std::uint8_t word;   // low byte of 6040h
  std::int64_t entry;  // of 1602h
  std::int64_t step;   // per SYNC
  ObjectAddress shown;
  std::int64_t shown_step;
  std::int64_t shown_short;  // by which the shown value lags, in each tick
};

// 6042h: 3 rpm are 204.8 UU/s; the ramp of 6048h, 6000 rpm/s, covers them within two ticks. 6043h
// is in rpm. 6074h is the command of the last of the 8 servo cycles of a tick, one eighth of a tick
// before its end.
constexpr std::array<StreamRow, 4> kStreamRows{{
    {"Velocity", 2, 0x7F, 0x60420010, 3, {0x6043, 0}, 3, 0},
    {"InterpolatedPosition", 7, 0x1F, 0x60C10120, 2, {0x6062, 0}, 2, 0},
    {"CyclicVelocity", 9, 0x0F, 0x60FF0020, -100, {0x606B, 0}, -100, 0},
    {"CyclicTorque", 10, 0x0F, 0x60710010, 80, {0x6074, 0}, 80, 10},
}};

class StreamBySync : public testing::TestWithParam<StreamRow> {};

// RPDOs received before SYNC n act at n in every mode.
TEST_P(StreamBySync, ActsInTheTickAfterSync) {
  const StreamRow& row = GetParam();
  BusOfBench bus(1, 1ms);
  TestMaster& master = bus.master();
  ASSERT_EQ(master.download(1, {0x1402, 1}, 0x80000401, 4), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1402, 2}, 1, 1), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1602, 0}, 0, 1), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1602, 1}, 0x60400010, 4), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1602, 2}, row.entry, 4), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1602, 0}, 2, 1), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1402, 1}, 0x401, 4), AbortCode::none);
  ASSERT_EQ(master.download(1, kMode, row.mode, 1), AbortCode::none);
  ASSERT_NO_FATAL_FAILURE(enable_by_sdo(bus, 1));
  master.send_nmt(kStart, 1);
  const auto size = static_cast<std::size_t>(row.entry & 0xFF) / 8;
  for (std::int64_t step = 1; step <= 10; ++step) {
    std::vector<std::uint8_t> data{row.word, 0x00};
    for (const std::uint8_t byte : little_endian(row.step * step, size)) data.push_back(byte);
    master.send(0x401, data);
    bus.sync();
    EXPECT_EQ(bus.read(1, row.shown, true), row.shown_step * step - row.shown_short) << step;
  }
  EXPECT_EQ(bus.statusword(1) & kStateBits, kShowsEnabled);
  EXPECT_EQ(bus.nodes().counters().refused_set_points, 0U);
}

INSTANTIATE_TEST_SUITE_P(SteppedBridge, StreamBySync, testing::ValuesIn(kStreamRows),
                         [](const auto& row) {
                           return std::string(row.param.name);
                         });

TEST(SteppedBridge, LetsTimePassAtSyncAlone) {
  BusOfBench bus(2, 5ms);
  const std::uint64_t begin = tick_of(bus);
  bus.master().send_nmt(kStart, 0);
  bus.master().send(0x201, {0x06, 0});
  (void)bus.read(1, kPosition);
  EXPECT_EQ(tick_of(bus), begin);
  bus.sync(3);
  EXPECT_EQ(tick_of(bus), begin + 15) << "ticks of 1 ms";
}

// CiA 301: a SYNC carries either no data or a counter of one byte.
TEST(SteppedBridge, LetsNoTimePassAtASyncOfAWrongLength) {
  BusOfBench bus(1, 1ms);
  const std::uint64_t begin = tick_of(bus);
  bus.master().send(0x080, {1, 2});
  bus.master().send(0x080, {1});
  EXPECT_EQ(tick_of(bus), begin);
  bus.master().send(0x080, {});
  EXPECT_EQ(tick_of(bus), begin + 1);
  ASSERT_EQ(bus.master().download(1, {0x1019, 0}, 10, 1), AbortCode::none);
  bus.master().send(0x080, {});
  EXPECT_EQ(tick_of(bus), begin + 1);
  bus.master().send(0x080, {1});
  EXPECT_EQ(tick_of(bus), begin + 2);
}

TEST(SteppedBridge, RefusesAnotherPeriodOfSync) {
  BusOfBench bus(1, 2ms);
  EXPECT_EQ(bus.master().download(1, {0x1006, 0}, 2000, 4), AbortCode::none);
  EXPECT_EQ(bus.master().download(1, {0x1006, 0}, 0, 4), AbortCode::none);
  EXPECT_NE(bus.master().download(1, {0x1006, 0}, 1000, 4), AbortCode::none);
}

TEST(SteppedBridge, CountsHeartbeatsInDriveTime) {
  BusOfBench bus(1, 1ms);
  ASSERT_EQ(bus.master().download(1, {0x1017, 0}, 10, 2), AbortCode::none);
  (void)bus.master().take_all();
  bus.sync(100);
  EXPECT_EQ(bus.master().count(0x701), 10U);
}

TEST(SteppedBridge, SendsAnEmergencyForAFaultAndForItsEnd) {
  BusOfBench bus(1, 1ms);
  client::Session session = bus.other_session();
  client::Axis axis = session.axis("1.1").value();
  ASSERT_TRUE(axis.disturb(client::Disturbance::over_current));
  (void)bus.master().take_all();
  bus.sync();
  const auto fault = bus.master().newest(0x081);
  ASSERT_TRUE(fault);
  EXPECT_EQ(number_in(*fault, 0, 2), 0x2310) << "continuous over-current";
  EXPECT_NE(fault->data[2] & 0x01, 0) << "1001h: generic error";
  EXPECT_EQ(bus.read(1, {0x1003, 1}) & 0xFFFF, 0x2310);
  ASSERT_TRUE(axis.disturb(client::Disturbance::over_current, 0));
  bus.sync(2);
  (void)bus.master().take_all();
  ASSERT_EQ(bus.master().download(1, kControlword, 0x80, 2), AbortCode::none);
  bus.sync(2);
  const auto end = bus.master().newest(0x081);
  ASSERT_TRUE(end);
  EXPECT_EQ(number_in(*end, 0, 2), 0x0000);
}

TEST(SteppedBridge, DetectsTheLossOfItsMasterByItsHeartbeat) {
  BusOfBench bus(1, 1ms);
  bus.master().send_nmt(kStart, 1);
  // Producer 127, 50 ms.
  ASSERT_EQ(bus.master().download(1, {0x1016, 1}, (0x7F << 16) | 50, 4), AbortCode::none);
  bus.sync(100);
  EXPECT_EQ(bus.master().count(0x081), 0U) << "it is watched from its first heartbeat on";
  for (int i = 0; i < 5; ++i) {
    bus.master().send(0x77F, {0x05});
    bus.sync(40);
  }
  EXPECT_EQ(bus.master().count(0x081), 0U);
  EXPECT_EQ(bus.nodes().node(0)->state(), NmtState::operational);
  bus.sync(20);
  const auto lost = bus.master().newest(0x081);
  ASSERT_TRUE(lost);
  EXPECT_EQ(number_in(*lost, 0, 2), 0x8130);
  EXPECT_EQ(bus.nodes().node(0)->state(), NmtState::pre_operational) << "1029h:01 = 0";
  EXPECT_EQ(bus.read(1, {0x5E0A, 0}), 1) << "test_connection_loss";
}

TEST(SteppedBridge, TellsTheDriveOfALossAlsoWhereATestHasLeft5E0AhAt1) {
  BusOfBench bus(1, 1ms);
  ASSERT_EQ(bus.master().download(1, {0x5E0A, 0}, 1, 1), AbortCode::none);
  ASSERT_EQ(bus.master().download(1, {0x1016, 1}, (0x7F << 16) | 50, 4), AbortCode::none);
  ASSERT_NO_FATAL_FAILURE(enable_by_sdo(bus, 1));
  bus.master().send(0x77F, {0x05});
  bus.sync(40);
  EXPECT_EQ(bus.statusword(1) & kStateBits, kShowsEnabled);
  bus.sync(500);
  EXPECT_EQ(bus.statusword(1) & kStateBits, kShowsFault) << "6007h = 1";
  EXPECT_EQ(bus.read(1, {0x603F, 0}), 0x8130);
}

TEST(SteppedBridge, ShowsAnAxisOfAnotherSessionAsNotRemote) {
  BusOfBench bus(2, 1ms);
  bus.master().send_nmt(kStart, 0);
  bus.sync();
  EXPECT_NE(bus.statusword(1) & kShowsRemote, 0);
  client::Session other = bus.other_session();
  ASSERT_TRUE(other.axis("1.1").value().take_over());
  bus.sync();
  const auto status = bus.master().newest(0x181);
  ASSERT_TRUE(status);
  EXPECT_EQ(number_in(*status, 0, 2) & kShowsRemote, 0);
  EXPECT_EQ(bus.statusword(1) & kShowsRemote, 0);
  EXPECT_NE(bus.statusword(2) & kShowsRemote, 0);
  EXPECT_EQ(bus.master().download(1, kControlword, 0x07, 2), AbortCode::refused_local_control);
  const auto ignored = bus.nodes().counters().ignored_set_points;
  bus.master().send(0x201, {0x06, 0});
  EXPECT_EQ(bus.nodes().counters().ignored_set_points, ignored + 1);
  ASSERT_TRUE(other.release());
  bus.sync(3);
  EXPECT_NE(bus.statusword(1) & kShowsRemote, 0) << "control comes back by itself";
}

TEST(SteppedBridge, PowerCyclesAtResetNode) {
  BusOfBench bus(2, 1ms);
  ASSERT_NO_FATAL_FAILURE(enable_by_sdo(bus, 1));
  ASSERT_EQ(bus.master().download(1, {0x6081, 0}, 12'345, 4), AbortCode::none);
  (void)bus.master().take_all();
  bus.master().send_nmt(kResetNode, 1);
  EXPECT_EQ(bus.master().count(0x701), 1U) << "boot-up";
  EXPECT_EQ(bus.master().count(0x702), 0U);
  // This read is executed after the power cycle: the accesses to an axis keep their order.
  EXPECT_NE(bus.read(1, {0x6081, 0}), 12'345);
  bus.sync(2);
  EXPECT_NE(bus.statusword(1) & kStateBits, kShowsEnabled);
}

/// Gives the node a TPDO1 of one byte that it sends at each TPDO1 of the other node.
void synchronise_with(BusOfBench& bus, std::uint8_t node, std::uint8_t other) {
  const std::int64_t id = 0x180 + node;
  TestMaster& master = bus.master();
  ASSERT_EQ(master.download(node, {0x1800, 1}, 0x80000000 | id, 4), AbortCode::none);
  ASSERT_EQ(master.download(node, {0x1800, 2}, 1, 1), AbortCode::none);
  ASSERT_EQ(master.download(node, {0x1A00, 0}, 0, 1), AbortCode::none);
  ASSERT_EQ(master.download(node, {0x1A00, 1}, 0x60610008, 4), AbortCode::none);
  ASSERT_EQ(master.download(node, {0x1A00, 0}, 1, 1), AbortCode::none);
  ASSERT_EQ(master.download(node, {0x1800, 1}, id, 4), AbortCode::none);
  ASSERT_EQ(master.download(node, {0x1019, 0}, 240, 1), AbortCode::none);
  ASSERT_EQ(master.download(node, {0x1005, 0}, 0x180 + other, 4), AbortCode::none);
}

TEST(SteppedBridge, EndsNodesThatAnswerEachOther) {
  BusOfBench bus(2, 1ms);
  ASSERT_NO_FATAL_FAILURE(synchronise_with(bus, 1, 2));
  ASSERT_NO_FATAL_FAILURE(synchronise_with(bus, 2, 1));
  bus.master().send_nmt(kStart, 0);
  (void)bus.master().take_all();
  bus.master().send(0x181, {1});  // the SYNC of node 2
  EXPECT_GT(bus.master().count(0x182), 1'000U);
  EXPECT_GT(bus.bridge().bus(0).bus().dropped_frames(), 0U);
  EXPECT_EQ(bus.read(2, {0x1000, 0}), 0x00020192) << "the nodes are there";
}

TEST(SteppedBridge, LosesItsNodesWithTheirBenchAndBootsThemWithTheNextOne) {
  BusOfBench bus(2, 1ms);
  bus.end_bench();
  ASSERT_TRUE(bus.master().wait_until([&bus] {
    return !bus.nodes().is_running();
  }));
  (void)bus.master().take_all();
  bus.sync();
  bus.master().send(0x601, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0});
  EXPECT_THAT(bus.master().received(), IsEmpty());
  bus.begin_bench();
  ASSERT_TRUE(bus.master().wait_for(0x702));
  EXPECT_EQ(bus.master().count(0x701), 1U);
  ASSERT_NO_FATAL_FAILURE(enable_by_sdo(bus, 2));
}

TEST(SteppedBridge, EndsWhileASyncWaitsForAnotherStepper) {
  BusOfBench bus(1, 1ms);
  client::Session other = bus.other_session();
  std::optional<client::Result<client::StepClock>> clock;
  // In another thread: a thread that steps a bench in this process with two sessions would wait for
  // itself.
  std::jthread([&] {
    clock.emplace(client::StepClock::join(other, std::array<std::uint32_t, 1>{1}));
  }).join();
  ASSERT_TRUE(*clock) << clock->outcome().message();
  const std::uint64_t begin = tick_of(bus);
  const std::jthread ending([&bus] {
    bus.bridge().stop();
  });
  // If the bridge did not end, each SYNC would wait a second, until the other stepper is removed
  // from the clock.
  bus.sync(100);
  EXPECT_TRUE(bus.bridge().loop().stopped());
  EXPECT_EQ(tick_of(bus), begin);
}

TEST(SteppedBridge, KeepsCommunicationParametersThatWereSaved) {
  const TemporaryDirectory directory;
  {
    BusOfBench bus(1, 1ms, directory.path().string());
    ASSERT_EQ(bus.master().download(1, {0x1017, 0}, 20, 2), AbortCode::none);
    ASSERT_EQ(bus.master().download(1, {0x1010, 1}, kStoreSignature, 4), AbortCode::none);
    ASSERT_EQ(bus.master().download(1, {0x1017, 0}, 30, 2), AbortCode::none) << "not saved";
  }
  BusOfBench bus(1, 1ms, directory.path().string());
  EXPECT_EQ(bus.read(1, {0x1017, 0}), 20);
  ASSERT_EQ(bus.master().download(1, {0x1011, 1}, kRestoreSignature, 4), AbortCode::none);
  bus.master().send_nmt(kResetNode, 1);
  EXPECT_EQ(bus.read(1, {0x1017, 0}), 0);
}

TEST(SteppedBridge, SavesNothingWhereTheDriveHasNoMemory) {
  BusOfBench bus(1, 1ms);
  ASSERT_EQ(bus.master().download(1, {0x1017, 0}, 20, 2), AbortCode::none);
  EXPECT_EQ(bus.master().download(1, {0x1010, 1}, kStoreSignature, 4),
            AbortCode::cannot_store_or_transfer);
  bus.master().send_nmt(kResetNode, 1);
  EXPECT_EQ(bus.read(1, {0x1017, 0}), 0);
}

TEST(SteppedBridge, GivesTheSameFramesEachTime) {
  const auto run = [] {
    BusOfBench bus(3, 1ms);
    bus.master().send_nmt(kStart, 0);
    for (const std::uint8_t word : kEnablingWords) {
      for (const std::uint32_t id : {0x201U, 0x202U, 0x203U}) bus.master().send(id, {word, 0});
      bus.sync(5);
      (void)bus.statusword(2);
    }
    return bus.master().take_all();
  };
  const std::vector<Frame> first = run();
  EXPECT_GT(first.size(), 20U);
  EXPECT_EQ(run(), first);
}

// ---- benches whose axes cannot be nodes ------------------------------------------------------

/// @return the reason for leaving out the bench; empty if it is served.
std::string left_out(const bench::BenchOptions& options, std::chrono::microseconds sync_steps,
                     std::int32_t offset) {
  const bench::Bench bench(options);
  canopen::Settings settings;
  settings.session.bus = bench.bus();
  settings.sync_steps = sync_steps;
  settings.buses.emplace_back().benches.push_back({.number = 1, .node_offset = offset});
  canopen::CanopenBridge bridge(settings);
  bridge.start();
  // A bench in real time is found once its own thread has sent the first status.
  const auto is_known = [&bridge] {
    return bridge.bus(0).nodes(1) != nullptr || !bridge.bus(0).left_out().empty();
  };
  EXPECT_TRUE(canopen::run_until(bridge.loop(), "the bench", is_known));
  const auto reasons = bridge.bus(0).left_out();
  return reasons.empty() ? "" : reasons.front();
}

TEST(SteppedBridge, LeavesOutABenchThatCannotBeServedAndSaysWhy) {
  const bench::BenchOptions stepped{.axes = 2, .clock = ClockMode::lockstep};
  const bench::BenchOptions real{.axes = 2, .clock = ClockMode::realtime};
  EXPECT_EQ(left_out(stepped, 1ms, 0), "");
  EXPECT_THAT(
      left_out(stepped, 1500us, 0),
      HasSubstr("bus 1: bench 1: --sync-steps 1500 us is not a multiple of its tick, 1000 us"));
  EXPECT_THAT(left_out(real, 1ms, 0), HasSubstr("its clock is realtime"));
  EXPECT_THAT(left_out(stepped, 1ms, 126), HasSubstr("axis 1.2 would be node 128"));
}

/// Maps these objects into TPDO1 of node 1, one entry of 1A00h each.
/// @param type 1800h:02
void map_first_tpdo(TestMaster& master, std::int64_t type,
                    const std::vector<std::int64_t>& entries) {
  ASSERT_EQ(master.download(1, {0x1800, 1}, 0x80000181, 4), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1800, 2}, type, 1), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1A00, 0}, 0, 1), AbortCode::none);
  std::uint8_t subindex = 0;
  for (const std::int64_t entry : entries) {
    ++subindex;
    ASSERT_EQ(master.download(1, {0x1A00, subindex}, entry, 4), AbortCode::none);
  }
  ASSERT_EQ(master.download(1, {0x1A00, 0}, subindex, 1), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1800, 1}, 0x181, 4), AbortCode::none);
}

// TPDOs at SYNC n carry the values sampled at n; RPDOs received before it act only afterwards.
TEST(SteppedBridge, CarriesInATpdoTheTargetThatWasInForceAtTheSample) {
  BusOfBench bus(1, 1ms);
  ASSERT_EQ(bus.master().download(1, kTarget, 55, 4), AbortCode::none);
  ASSERT_NO_FATAL_FAILURE(map_first_tpdo(bus.master(), 1, {0x607A0020, 0x60400010}));
  bus.master().send_nmt(kStart, 1);
  bus.master().send(0x401, {0x06, 0x00, 77, 0, 0, 0});  // RPDO3: 6040h and 607Ah
  bus.sync();
  const auto before = bus.master().newest(0x181);
  ASSERT_TRUE(before);
  ASSERT_EQ(before->size, 6);
  EXPECT_EQ(number_in(*before, 0, 4), 55);
  EXPECT_EQ(number_in(*before, 4, 2), 0);
  bus.sync();
  const auto behind = bus.master().newest(0x181);
  ASSERT_TRUE(behind);
  EXPECT_EQ(number_in(*behind, 0, 4), 77);
  EXPECT_EQ(number_in(*behind, 4, 2), 0x06);
}

TEST(SteppedBridge, CarriesInATpdoReadOnlyObjectsThatTheStatusDoesNotHave) {
  BusOfBench bus(1, 1ms);
  ASSERT_NO_FATAL_FAILURE(map_first_tpdo(bus.master(), 1, {0x60790020, 0x65020020}));
  bus.master().send_nmt(kStart, 1);
  bus.sync();
  const auto sampled = bus.master().newest(0x181);
  ASSERT_TRUE(sampled);
  EXPECT_EQ(number_in(*sampled, 0, 4), bus.read(1, {0x6079, 0}));
  EXPECT_EQ(number_in(*sampled, 4, 4), bus.read(1, {0x6502, 0}));
}

// A PDO has no answer. The drive does not have mode 50.
TEST(SteppedBridge, CountsAValueOfAPdoThatTheDriveRefuses) {
  BusOfBench bus(1, 1ms);
  bus.master().send_nmt(kStart, 1);
  bus.master().send(0x301, {0x06, 0x00, 50});  // RPDO2: 6040h and 6060h
  bus.sync();
  EXPECT_TRUE(bus.master().wait_until([&bus] {
    return bus.nodes().counters().refused_set_points == 1;
  }));
  EXPECT_THAT(bus.bridge().counter_lines().front(), HasSubstr(", 1 refused values of PDOs, "));
}

/// A private bridge with a socketcand server, where each SYNC lets 1 ms pass.
canopen::Settings private_settings(std::size_t nodes) {
  canopen::Settings settings;
  settings.is_private = true;
  settings.sync_steps = 1ms;
  settings.buses.emplace_back(canopen::BusSetting{.socketcand = {{.host = "127.0.0.1", .port = 0}},
                                                  .benches = {{.axes = nodes}}});
  complete_settings(settings);
  return settings;
}

/// @return the number of frames that a socketcand client received, for each TPDO of each node.
std::map<std::string, std::size_t> tpdos_in(const std::string& received) {
  constexpr std::string_view kFrame = "< frame ";
  constexpr std::size_t kDigits = 3;
  std::map<std::string, std::size_t> counts;
  for (std::size_t at = received.find(kFrame); at != std::string::npos;
       at = received.find(kFrame, at + 1)) {
    const std::string id = received.substr(at + kFrame.size(), kDigits);
    if (id >= "181" && id < "500") ++counts[id];
  }
  return counts;
}

/// Makes four TPDOs of each node answer each SYNC, and switches off all other frames.
void answer_each_sync(canopen::CanopenBridge& bridge, std::size_t nodes) {
  TestMaster master(bridge.bus(0).bus(), [] {});
  for (std::size_t node = 1; node <= nodes; ++node) {
    for (std::uint16_t pdo = 0x1800; pdo < 0x1804; ++pdo) {
      ASSERT_EQ(master.download(static_cast<std::uint8_t>(node), {pdo, 2}, 1, 1), AbortCode::none);
    }
  }
  master.send_nmt(kStart, 0);
}

struct Flood {
  std::size_t nodes;
  std::size_t syncs;
};

class FloodOfSyncs : public testing::TestWithParam<Flood> {};

// 4,000 SYNCs request 48,000 TPDOs from three nodes, and 60 SYNCs 30,480 from 127 nodes: more than
// the 16,384 frames that may wait for a client.
TEST_P(FloodOfSyncs, LosesNoTpdoOfAMasterThatSendsAllBeforeItReads) {
  const auto [nodes, syncs] = GetParam();
  canopen::CanopenBridge bridge(private_settings(nodes));
  bridge.start();
  ASSERT_NO_FATAL_FAILURE(answer_each_sync(bridge, nodes));
  canopen::TcpPeer peer(bridge.loop(), bridge.bus(0).socketcand().value());
  std::string words = "< open can0 >< rawmode >";
  for (std::size_t i = 0; i < syncs; ++i) words += "< send 80 0 >";
  peer.send(words + "< echo >");
  peer.read();
  const std::size_t wanted = syncs * nodes * 4;
  EXPECT_TRUE(canopen::run_until(bridge.loop(), "the answers to all SYNCs", [&] {
    return peer.received_frames() >= wanted;
  }));
  const auto counts = tpdos_in(peer.received());
  EXPECT_EQ(counts.size(), nodes * 4);
  for (const auto& [id, count] : counts) EXPECT_EQ(count, syncs) << id;
  EXPECT_THAT(bridge.counter_lines().front(), HasSubstr(", 0 frames not read in time, "));
}

INSTANTIATE_TEST_SUITE_P(SteppedBridge, FloodOfSyncs,
                         testing::Values(Flood{.nodes = 3, .syncs = 4'000},
                                         Flood{.nodes = 127, .syncs = 60}),
                         [](const auto& flood) {
                           return "With" + std::to_string(flood.param.nodes) + "Nodes";
                         });

// A bench begins at tick 1: SYNC n is at n ms, when its TPDOs are sampled.
TEST(SteppedBridge, StampsFramesWithTheTimeOfTheDrives) {
  canopen::CanopenBridge bridge(private_settings(1));
  bridge.start();
  ASSERT_NO_FATAL_FAILURE(answer_each_sync(bridge, 1));
  canopen::TcpPeer peer(bridge.loop(), bridge.bus(0).socketcand().value());
  peer.read();
  peer.send("< open can0 >< rawmode >< send 80 0 >< send 80 0 >< send 80 0 >");
  EXPECT_TRUE(canopen::run_until(bridge.loop(), "twelve TPDOs", [&] {
    return peer.received_frames() == 12;
  }));
  for (const std::string time : {"0.001000", "0.002000", "0.003000"}) {
    EXPECT_THAT(peer.received(), HasSubstr("< frame 181 " + time + " "));
  }
}

// The master of an SDO receives the abort code.
TEST(SteppedBridge, CountsNoRefusalOfAnSdoAsThatOfAPdo) {
  BusOfBench bus(1, 1ms);
  EXPECT_EQ(bus.master().download(1, kMode, 50, 1), AbortCode::value_range_exceeded);
  bus.sync(3);
  EXPECT_EQ(bus.nodes().counters().refused_set_points, 0U);
}

}  // namespace
}  // namespace vdrive::test
