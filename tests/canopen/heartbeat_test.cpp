// SPDX-License-Identifier: Apache-2.0
// Heartbeat producer and consumer on their own, then the reaction of a node (node 1).
#include "node/heartbeat.hpp"

#include "canopen/fake_host.hpp"
#include "node/node.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

/// A producer whose node is in Pre-operational.
struct ProducerUnderTest {
  FakeHost host;
  HeartbeatProducer producer{5, host};

  std::vector<std::string> advance(DriveTime now) {
    producer.advance(NmtState::pre_operational, now);
    return host.take();
  }
};

TEST(HeartbeatProducer, SendsNothingAfterTheBootUpByDefault) {
  ProducerUnderTest under_test;
  under_test.producer.boot_up(0ms);
  EXPECT_THAT(under_test.host.take(), ElementsAre("705#00"));
  EXPECT_EQ(under_test.producer.time(), 0);
  EXPECT_EQ(under_test.producer.next_due(), std::nullopt);
  EXPECT_THAT(under_test.advance(1h), IsEmpty());
}

TEST(HeartbeatProducer, BeginsAtOnceWhenItsTimeIsWritten) {
  ProducerUnderTest under_test;
  under_test.producer.set_time(100, 7ms);
  EXPECT_EQ(under_test.producer.next_due(), DriveTime(7ms));
  EXPECT_THAT(under_test.advance(7ms), ElementsAre("705#7F"));
  EXPECT_EQ(under_test.producer.next_due(), DriveTime(107ms));
}

TEST(HeartbeatProducer, SendsOneHeartbeatAPeriod) {
  ProducerUnderTest under_test;
  under_test.producer.set_time(100, 0ms);
  under_test.advance(0ms);
  EXPECT_THAT(under_test.advance(99'999us), IsEmpty());
  EXPECT_THAT(under_test.advance(100ms), ElementsAre("705#7F"));
  EXPECT_THAT(under_test.advance(100ms), IsEmpty());
  EXPECT_THAT(under_test.advance(200ms), ElementsAre("705#7F"));
}

TEST(HeartbeatProducer, CountsTheBootUpMessageAsTheFirstHeartbeat) {
  ProducerUnderTest under_test;
  under_test.producer.set_time(100, 0ms);
  under_test.producer.boot_up(0ms);
  EXPECT_THAT(under_test.host.take(), ElementsAre("705#00"));
  EXPECT_THAT(under_test.advance(99ms), IsEmpty());
  EXPECT_THAT(under_test.advance(100ms), ElementsAre("705#7F"));
}

TEST(HeartbeatProducer, CarriesTheStateOfTheNode) {
  ProducerUnderTest under_test;
  under_test.producer.set_time(1, 0ms);
  under_test.producer.advance(NmtState::operational, 0ms);
  under_test.producer.advance(NmtState::stopped, 1ms);
  EXPECT_THAT(under_test.host.take(), ElementsAre("705#05", "705#04"));
}

TEST(HeartbeatProducer, IsNotShiftedByALateCall) {
  ProducerUnderTest under_test;
  under_test.producer.set_time(100, 0ms);
  under_test.advance(0ms);
  EXPECT_THAT(under_test.advance(130ms), ElementsAre("705#7F"));
  EXPECT_EQ(under_test.producer.next_due(), DriveTime(200ms));
}

TEST(HeartbeatProducer, MakesUpForNoPeriodThatHasPassed) {
  ProducerUnderTest under_test;
  under_test.producer.set_time(100, 0ms);
  under_test.advance(0ms);
  EXPECT_THAT(under_test.advance(550ms), ElementsAre("705#7F"));
  EXPECT_EQ(under_test.producer.next_due(), DriveTime(650ms));
}

TEST(HeartbeatProducer, EndsWithTime0) {
  ProducerUnderTest under_test;
  under_test.producer.set_time(100, 0ms);
  under_test.producer.set_time(0, 50ms);
  EXPECT_EQ(under_test.producer.next_due(), std::nullopt);
  EXPECT_THAT(under_test.advance(1s), IsEmpty());
}

TEST(HeartbeatProducer, HasItsDefaultAgainAfterAReset) {
  ProducerUnderTest under_test;
  under_test.producer.set_time(100, 0ms);
  under_test.producer.reset();
  EXPECT_EQ(under_test.producer.time(), 0);
  EXPECT_EQ(under_test.producer.next_due(), std::nullopt);
}

/// @return an entry of 1016h.
constexpr std::uint32_t consumer_entry(std::uint32_t producer, std::uint32_t milliseconds) {
  return producer << 16U | milliseconds;
}

TEST(HeartbeatConsumer, WatchesAProducerFromItsFirstHeartbeatOn) {
  HeartbeatConsumer consumer;
  EXPECT_EQ(consumer.set_entry(1, consumer_entry(9, 200)), AbortCode::none);
  EXPECT_EQ(consumer.next_due(), std::nullopt);
  EXPECT_EQ(consumer.take_silent(1h), std::nullopt) << "one that was never heard";
  consumer.receive(9, 1s);
  EXPECT_EQ(consumer.next_due(), DriveTime(1'200ms));
}

TEST(HeartbeatConsumer, FindsAProducerSilentAtTheEndOfItsTime) {
  HeartbeatConsumer consumer;
  consumer.set_entry(1, consumer_entry(9, 200));
  consumer.receive(9, 1s);
  EXPECT_EQ(consumer.take_silent(1'199'999us), std::nullopt);
  EXPECT_FALSE(consumer.has_silent());
  EXPECT_EQ(consumer.take_silent(1'200ms), std::uint8_t{9});
  EXPECT_TRUE(consumer.has_silent());
}

TEST(HeartbeatConsumer, NamesASilentProducerOnce) {
  HeartbeatConsumer consumer;
  consumer.set_entry(1, consumer_entry(9, 200));
  consumer.receive(9, 0s);
  EXPECT_EQ(consumer.take_silent(1s), std::uint8_t{9});
  EXPECT_EQ(consumer.take_silent(1s), std::nullopt);
  EXPECT_EQ(consumer.next_due(), std::nullopt);
  EXPECT_TRUE(consumer.has_silent()) << "still";
}

TEST(HeartbeatConsumer, IsContentWithEachHeartbeat) {
  HeartbeatConsumer consumer;
  consumer.set_entry(1, consumer_entry(9, 200));
  for (DriveTime now = 0ms; now < 2s; now += 199ms) {
    EXPECT_EQ(consumer.take_silent(now), std::nullopt);
    consumer.receive(9, now);
  }
}

TEST(HeartbeatConsumer, WatchesASilentProducerAgainWhenItIsBack) {
  HeartbeatConsumer consumer;
  consumer.set_entry(1, consumer_entry(9, 200));
  consumer.receive(9, 0s);
  consumer.take_silent(1s);
  consumer.receive(9, 2s);
  EXPECT_FALSE(consumer.has_silent());
  EXPECT_EQ(consumer.take_silent(2'200ms), std::uint8_t{9});
}

TEST(HeartbeatConsumer, IgnoresOtherNodes) {
  HeartbeatConsumer consumer;
  consumer.set_entry(1, consumer_entry(9, 200));
  consumer.receive(8, 0s);
  EXPECT_EQ(consumer.next_due(), std::nullopt);
}

TEST(HeartbeatConsumer, UsesNoEntryWithoutTimeOrWithoutANodeId) {
  HeartbeatConsumer consumer;
  for (const std::uint32_t value :
       {consumer_entry(9, 0), consumer_entry(0, 200), consumer_entry(128, 200)}) {
    EXPECT_EQ(consumer.set_entry(1, value), AbortCode::none);
    EXPECT_EQ(consumer.entry(1), value);
    for (const int producer : {0, 9, 128}) {
      consumer.receive(static_cast<std::uint8_t>(producer), 0s);
    }
    EXPECT_EQ(consumer.next_due(), std::nullopt) << value;
  }
}

TEST(HeartbeatConsumer, RefusesTheSameProducerTwiceWith06040043) {
  HeartbeatConsumer consumer;
  EXPECT_EQ(consumer.set_entry(1, consumer_entry(9, 200)), AbortCode::none);
  EXPECT_EQ(consumer.set_entry(4, consumer_entry(9, 300)), AbortCode::parameter_incompatibility);
  EXPECT_EQ(consumer.entry(4), 0U);
}

TEST(HeartbeatConsumer, TakesTheSameProducerTwiceWhereOneIsNotUsed) {
  HeartbeatConsumer consumer;
  EXPECT_EQ(consumer.set_entry(1, consumer_entry(9, 200)), AbortCode::none);
  EXPECT_EQ(consumer.set_entry(2, consumer_entry(9, 0)), AbortCode::none);
  EXPECT_EQ(consumer.set_entry(1, consumer_entry(9, 0)), AbortCode::none);
  EXPECT_EQ(consumer.set_entry(2, consumer_entry(9, 300)), AbortCode::none);
}

TEST(HeartbeatConsumer, TakesAnotherTimeForTheSameProducer) {
  HeartbeatConsumer consumer;
  consumer.set_entry(1, consumer_entry(9, 200));
  EXPECT_EQ(consumer.set_entry(1, consumer_entry(9, 300)), AbortCode::none);
  EXPECT_EQ(consumer.entry(1), consumer_entry(9, 300));
}

TEST(HeartbeatConsumer, RefusesReservedBitsWith06090030) {
  HeartbeatConsumer consumer;
  EXPECT_EQ(consumer.set_entry(1, 0x0109'00C8), AbortCode::value_range_exceeded);
  EXPECT_EQ(consumer.set_entry(1, 0x8009'00C8), AbortCode::value_range_exceeded);
  EXPECT_EQ(consumer.entry(1), 0U);
}

TEST(HeartbeatConsumer, WaitsForAFirstHeartbeatAgainWhenAnEntryIsWritten) {
  HeartbeatConsumer consumer;
  consumer.set_entry(1, consumer_entry(9, 200));
  consumer.receive(9, 0s);
  consumer.take_silent(1s);
  consumer.set_entry(1, consumer_entry(9, 200));
  EXPECT_FALSE(consumer.has_silent());
  EXPECT_EQ(consumer.take_silent(1h), std::nullopt);
}

TEST(HeartbeatConsumer, WatchesFourProducersEachWithItsTime) {
  HeartbeatConsumer consumer;
  for (std::uint8_t entry = 1; entry <= HeartbeatConsumer::kEntries; ++entry) {
    EXPECT_EQ(consumer.set_entry(entry, consumer_entry(10U + entry, 400U - 100U * (entry - 1U))),
              AbortCode::none);
    consumer.receive(static_cast<std::uint8_t>(10 + entry), 0s);
  }
  EXPECT_EQ(consumer.next_due(), DriveTime(100ms)) << "of the fourth";
  EXPECT_EQ(consumer.take_silent(250ms), std::uint8_t{13});
  EXPECT_EQ(consumer.take_silent(250ms), std::uint8_t{14});
  EXPECT_EQ(consumer.take_silent(250ms), std::nullopt);
  EXPECT_EQ(consumer.next_due(), DriveTime(300ms));
  consumer.receive(13, 260ms);
  EXPECT_TRUE(consumer.has_silent()) << "14";
}

TEST(HeartbeatConsumer, WatchesNobodyAfterAReset) {
  HeartbeatConsumer consumer;
  consumer.set_entry(1, consumer_entry(9, 200));
  consumer.receive(9, 0s);
  consumer.take_silent(1s);
  consumer.reset();
  EXPECT_EQ(consumer.entry(1), 0U);
  EXPECT_FALSE(consumer.has_silent());
  EXPECT_EQ(consumer.next_due(), std::nullopt);
}

/// Node 1 watches node 9h with 200 ms and has received its heartbeat at 0 s. The values of its
/// drive are all 0.
struct WatchingNode {
  FakeHost host;
  Node node{{.node_id = 1}, host};
  DriveView drive;

  WatchingNode() {
    node.start(drive, 0s);
    receive("601#23161001C8000900");
    receive("709#05");
    host.take();
  }

  std::vector<std::string> receive(std::string_view frame, DriveTime now = 0s) {
    node.receive(frame_of(frame), now);
    return host.take();
  }

  std::vector<std::string> advance(DriveTime now) {
    node.advance(now);
    return host.take();
  }

  std::vector<std::string> update(DriveTime now) {
    node.update(drive, now);
    return host.take();
  }

  /// The drive reacts to the lost master with a fault, as configured by 6007h = 1.
  void fault() {
    drive.status.error_code = 0x8130;
    drive.status.error_register = 0x11;
    ++drive.status.fault_count;
  }

  void reset_fault() {
    drive.status.error_code = 0;
    drive.status.error_register = 0;
  }
};

// Error code 8130h; 1001h = 11h (generic and communication); 6041h, 6061h and the number of faults
// are 0; the silent producer is node 9.
TEST(HeartbeatError, IsReportedWithEmergency8130AndALostConnection) {
  WatchingNode watching;
  EXPECT_EQ(watching.node.next_due(), DriveTime(200ms));
  EXPECT_THAT(watching.advance(199ms), IsEmpty());
  EXPECT_THAT(watching.host.connection_lost, IsEmpty());
  EXPECT_THAT(watching.advance(200ms), ElementsAre("081#3081110000000009"));
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true));
  EXPECT_EQ(watching.node.next_due(), std::nullopt);
  EXPECT_THAT(watching.advance(10s), IsEmpty()) << "once";
}

TEST(HeartbeatError, CountsTheBootUpMessageAsAHeartbeat) {
  WatchingNode watching;
  watching.receive("709#00", 150ms);
  EXPECT_EQ(watching.node.next_due(), DriveTime(350ms));
  EXPECT_THAT(watching.advance(350ms), ElementsAre("081#3081110000000009"))
      << "a master that was reset and is silent since";
}

TEST(HeartbeatError, DoesNotOccurWhileTheEntriesAre0) {
  WatchingNode watching;
  watching.receive("601#2316100100000000", 100ms);
  EXPECT_EQ(watching.node.next_due(), std::nullopt);
  EXPECT_THAT(watching.advance(10s), IsEmpty());
  EXPECT_THAT(watching.host.connection_lost, IsEmpty());
}

TEST(HeartbeatError, IsNotPreventedByFramesOfAnotherLengthAndRemoteFrames) {
  WatchingNode watching;
  watching.receive("709#0505", 100ms);
  watching.receive("709#", 100ms);
  watching.receive("709#R", 100ms);
  EXPECT_EQ(watching.node.next_due(), DriveTime(200ms));
}

TEST(HeartbeatError, EndsWhenTheProducerIsBack) {
  WatchingNode watching;
  watching.advance(200ms);
  EXPECT_THAT(watching.receive("709#05", 300ms), ElementsAre("081#0000000000000000"));
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true, false));
  EXPECT_THAT(watching.advance(500ms), ElementsAre("081#3081110000000009")) << "and is watched";
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true, false, true));
}

TEST(HeartbeatError, EndsWhenTheProducerIsNotWatchedAnyMore) {
  WatchingNode watching;
  watching.advance(200ms);
  EXPECT_THAT(watching.receive("601#2316100100000000", 300ms),
              ElementsAre("581#6016100100000000", "081#0000000000000000"));
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true, false));
}

TEST(HeartbeatError, IsReportedOnceWithTheFaultThatItCausesInTheDrive) {
  WatchingNode watching;
  watching.advance(200ms);
  watching.fault();
  EXPECT_THAT(watching.update(201ms), IsEmpty());
  EXPECT_THAT(watching.receive("709#05", 300ms), IsEmpty()) << "the drive still has its fault";
  watching.reset_fault();
  EXPECT_THAT(watching.update(301ms), ElementsAre("081#0000000000000100"))
      << "byte 6: one fault since power-up";
}

TEST(HeartbeatError, StaysInTheErrorRegisterWhenTheFaultOfTheDriveIsResetBefore) {
  WatchingNode watching;
  watching.advance(200ms);
  watching.fault();
  watching.update(201ms);
  watching.reset_fault();
  EXPECT_THAT(watching.update(301ms), ElementsAre("081#0000110000000100"));
  EXPECT_THAT(watching.receive("709#05", 400ms), ElementsAre("081#0000000000000100"));
}

TEST(HeartbeatError, ShowsIn1001h) {
  WatchingNode watching;
  watching.advance(200ms);
  watching.receive("601#4001100000000000", 300ms);
  ASSERT_EQ(watching.host.accesses.size(), 1U);
  watching.node.complete(watching.host.accesses[0].ticket, {.value = 0x20}, 300ms);
  EXPECT_THAT(watching.host.take(), ElementsAre("581#4F01100031000000")) << "20h | 11h";
}

TEST(HeartbeatError, LastsUntilAllProducersAreBack) {
  WatchingNode watching;
  watching.receive("601#23161002C8000A00");
  watching.receive("70A#05");
  EXPECT_THAT(watching.advance(200ms), ElementsAre("081#3081110000000009", "081#308111000000000A"));
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true));
  EXPECT_THAT(watching.receive("709#05", 300ms), IsEmpty());
  EXPECT_THAT(watching.receive("70A#05", 300ms), ElementsAre("081#0000000000000000"));
}

// Between two losses another master may have reset the fault of the first and enabled the drive.
TEST(HeartbeatError, IsASeparateLossForEachProducer) {
  WatchingNode watching;
  watching.receive("601#23161002F4010A00");  // node Ah, 500 ms
  watching.receive("70A#05");
  watching.advance(200ms);
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true));
  EXPECT_THAT(watching.advance(500ms), ElementsAre("081#308111000000000A"));
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true, true));
}

// A master may enable the drive by SDO without an NMT start of the node.
TEST(HeartbeatError, IsALossToTheDriveAlsoAfterAStopByNmt) {
  WatchingNode watching;
  watching.receive("000#0101");
  watching.receive("000#0201");
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true)) << "the stop";
  watching.receive("000#8001");
  EXPECT_THAT(watching.advance(200ms), ElementsAre("081#3081110000000009"));
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true, true));
}

struct BehaviourRow {
  const char* name;
  const char* value;  ///< of 1029h:01, in hex
  NmtState from;
  NmtState to;
};

std::ostream& operator<<(std::ostream& stream, const BehaviourRow& row) {
  return stream << row.name;
}

class ErrorBehaviour : public testing::TestWithParam<BehaviourRow> {};

TEST_P(ErrorBehaviour, LeadsToTheStateOf1029h) {
  WatchingNode watching;
  watching.receive("601#2F291001" + std::string(GetParam().value) + "000000");
  if (GetParam().from == NmtState::operational) watching.receive("000#0101");
  ASSERT_EQ(watching.node.state(), GetParam().from);
  EXPECT_THAT(watching.advance(200ms), Contains("081#3081110000000009"));
  EXPECT_EQ(watching.node.state(), GetParam().to);
}

INSTANTIATE_TEST_SUITE_P(
    Each, ErrorBehaviour,
    testing::Values(
        BehaviourRow{"Value0InOperational", "00", NmtState::operational, NmtState::pre_operational},
        BehaviourRow{"Value0InPreOperational", "00", NmtState::pre_operational,
                     NmtState::pre_operational},
        BehaviourRow{"Value1InOperational", "01", NmtState::operational, NmtState::operational},
        BehaviourRow{"Value2InOperational", "02", NmtState::operational, NmtState::stopped},
        BehaviourRow{"Value2InPreOperational", "02", NmtState::pre_operational, NmtState::stopped}),
    [](const auto& row) {
      return std::string(row.param.name);
    });

TEST(HeartbeatError, EndsForTheDriveWhenAMasterStartsTheNode) {
  WatchingNode watching;
  watching.receive("000#0101");
  watching.advance(200ms);
  EXPECT_EQ(watching.node.state(), NmtState::pre_operational);
  watching.receive("000#0101", 300ms);
  EXPECT_EQ(watching.node.state(), NmtState::operational);
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true, false));
}

TEST(HeartbeatError, OccursInStoppedToo) {
  WatchingNode watching;
  watching.receive("000#0201");
  EXPECT_THAT(watching.advance(200ms), IsEmpty()) << "Stopped has no emergencies";
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true));
  EXPECT_THAT(watching.receive("000#8001", 250ms), ElementsAre("081#3081110000000009"))
      << "it comes when the state has them again";
}

TEST(HeartbeatError, IsForgottenWithAResetOfTheCommunication) {
  WatchingNode watching;
  watching.advance(200ms);
  EXPECT_THAT(watching.receive("000#8201", 300ms), ElementsAre("701#00"));
  EXPECT_THAT(watching.host.connection_lost, ElementsAre(true, false));
  EXPECT_EQ(watching.node.value({0x1016, 1}), 0);
  EXPECT_EQ(watching.node.next_due(), std::nullopt);
}

}  // namespace
}  // namespace vdrive::canopen
