// SPDX-License-Identifier: Apache-2.0
// A node: NMT, SDO access to its own objects and to those of the drive, PDOs in each state, store
// and restore. Node 1: SDO 601h and 581h, boot-up and heartbeat 701h, EMCY 081h, RPDO1 201h, TPDO1
// 181h.
#include "node/node.hpp"

#include "canopen/fake_host.hpp"
#include "node/node_object.hpp"
#include "support/random_cases.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <rapidcheck.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;
using testing::Pair;
using testing::StartsWith;

constexpr const char* kStart = "000#0101";
constexpr const char* kStop = "000#0201";
constexpr const char* kPreOperational = "000#8001";
constexpr const char* kResetNode = "000#8101";
constexpr const char* kResetCommunication = "000#8201";
constexpr const char* kSave = "601#2310100173617665";
constexpr const char* kLoad = "601#231110016C6F6164";

/// Node 1 after its boot-up.
struct NodeUnderTest {
  FakeHost host;
  Node node;
  DriveView drive;
  DriveTime now{};

  explicit NodeUnderTest(Node::Parameters stored = {})
      : node({.node_id = 1, .software_version = "1.2.3"}, host, std::move(stored)) {
    drive.status.ds402_statusword = 0x0637;
    node.start(drive, now);
    host.take();
  }

  std::vector<std::string> receive(std::string_view frame) {
    node.receive(frame_of(frame), now);
    return host.take();
  }

  std::vector<std::string> update() {
    node.update(drive, now);
    return host.take();
  }

  std::vector<std::string> advance(DriveTime time) {
    now = time;
    node.advance(now);
    return host.take();
  }

  /// Answers the latest access that the node has begun.
  std::vector<std::string> answer(const DriveAnswer& answer) {
    node.complete(host.accesses.back().ticket, answer, now);
    return host.take();
  }
};

// --- NMT ---

TEST(Node, SendsItsBootUpMessageAndIsPreOperational) {
  FakeHost host;
  Node node({.node_id = 42}, host);
  EXPECT_EQ(node.state(), NmtState::boot_up);
  EXPECT_EQ(node.id(), 42);
  node.start({}, 0s);
  EXPECT_THAT(host.take(), ElementsAre("72A#00"));
  EXPECT_EQ(node.state(), NmtState::pre_operational);
}

TEST(Node, DoesNothingBeforeItsStart) {
  FakeHost host;
  Node node({.node_id = 1}, host);
  DriveView drive;
  drive.status.error_code = 0x8611;
  for (const char* const frame : {"601#4000100000000000", kStart, kResetNode, "201#0600", "080#"}) {
    node.receive(frame_of(frame), 0s);
  }
  node.update(drive, 0s);
  node.advance(1h);
  EXPECT_THAT(host.frames, IsEmpty());
  EXPECT_THAT(host.accesses, IsEmpty());
  EXPECT_EQ(host.power_cycles, 0);
  EXPECT_EQ(node.next_due(), std::nullopt);
}

struct NmtRow {
  const char* name;
  const char* command;
  NmtState state;
};

std::ostream& operator<<(std::ostream& stream, const NmtRow& row) {
  return stream << row.name;
}

class NmtCommand : public testing::TestWithParam<NmtRow> {
 protected:
  NodeUnderTest test;
};

TEST_P(NmtCommand, LeadsToItsStateFromEachState) {
  for (const char* const before : {kStart, kStop, kPreOperational}) {
    test.receive(before);
    test.receive("000#" + std::string(GetParam().command) + "01");
    EXPECT_EQ(test.node.state(), GetParam().state) << before;
  }
}

TEST_P(NmtCommand, IsTakenByAllNodesWhenItNamesNode0) {
  test.receive("000#" + std::string(GetParam().command) + "00");
  EXPECT_EQ(test.node.state(), GetParam().state);
}

TEST_P(NmtCommand, IsLeftToTheNodeThatItNames) {
  test.receive("000#" + std::string(GetParam().command) + "02");
  EXPECT_EQ(test.node.state(), NmtState::pre_operational);
  EXPECT_EQ(test.host.power_cycles, 0);
}

INSTANTIATE_TEST_SUITE_P(
    Each, NmtCommand,
    testing::Values(NmtRow{"Start", "01", NmtState::operational},
                    NmtRow{"Stop", "02", NmtState::stopped},
                    NmtRow{"EnterPreOperational", "80", NmtState::pre_operational},
                    NmtRow{"ResetNode", "81", NmtState::pre_operational},
                    NmtRow{"ResetCommunication", "82", NmtState::pre_operational}),
    [](const auto& row) {
      return std::string(row.param.name);
    });

TEST(Node, IgnoresNmtFramesOfAnotherLengthAndCountsThem) {
  NodeUnderTest test;
  for (const char* const frame :
       {"000#", "000#01", "000#010100", "000#0101000000000000", "000#R"}) {
    test.receive(frame);
    EXPECT_EQ(test.node.state(), NmtState::pre_operational) << frame;
  }
  EXPECT_EQ(test.node.counters().ignored_frames, 5U);
}

TEST(Node, IgnoresUnknownNmtCommandsAndCountsThem) {
  NodeUnderTest test;
  for (const char* const frame : {"000#0001", "000#0301", "000#7F01", "000#8301", "000#FF01"}) {
    EXPECT_THAT(test.receive(frame), IsEmpty());
    EXPECT_EQ(test.node.state(), NmtState::pre_operational) << frame;
  }
  EXPECT_EQ(test.node.counters().ignored_frames, 5U);
}

TEST(Node, SendsItsBootUpMessageAtEachReset) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive(kResetCommunication), ElementsAre("701#00"));
  EXPECT_THAT(test.receive(kResetNode), ElementsAre("701#00"));
  test.receive(kStop);
  EXPECT_THAT(test.receive(kResetCommunication), ElementsAre("701#00"));
}

TEST(Node, SwitchesTheDriveOffAndOnAtResetNodeOnly) {
  NodeUnderTest test;
  for (const char* const frame : {kStart, kStop, kPreOperational, kResetCommunication}) {
    test.receive(frame);
  }
  EXPECT_EQ(test.host.power_cycles, 0);
  test.receive(kResetNode);
  EXPECT_EQ(test.host.power_cycles, 1);
}

TEST(Node, ReportsALostMasterWhenItIsStoppedOrReset) {
  for (const char* const frame : {kStop, kResetNode, kResetCommunication}) {
    NodeUnderTest test;
    test.receive(kStart);
    EXPECT_THAT(test.host.connection_lost, IsEmpty());
    test.receive(frame);
    EXPECT_THAT(test.host.connection_lost, ElementsAre(true)) << frame;
    test.receive(frame);
    EXPECT_THAT(test.host.connection_lost, ElementsAre(true)) << frame;
    test.receive(kStart);
    EXPECT_THAT(test.host.connection_lost, ElementsAre(true, false)) << frame;
  }
}

TEST(Node, ReportsNoLostMasterWhenNoneHasStartedIt) {
  NodeUnderTest test;
  for (const char* const frame : {kStop, kPreOperational, kResetCommunication, kResetNode}) {
    test.receive(frame);
  }
  EXPECT_THAT(test.host.connection_lost, IsEmpty());
}

TEST(Node, ReportsNoLostMasterWhenItGoesToPreOperational) {
  NodeUnderTest test;
  test.receive(kStart);
  test.receive(kPreOperational);
  EXPECT_THAT(test.host.connection_lost, IsEmpty());
  test.receive(kStop);
  EXPECT_THAT(test.host.connection_lost, ElementsAre(true)) << "its master had started it";
}

TEST(Node, HasItsMasterAgainWhenTheDriveIsThereAgain) {
  NodeUnderTest test;
  test.receive(kStart);
  test.receive(kStop);
  test.node.start(test.drive, 0s);
  EXPECT_THAT(test.host.connection_lost, ElementsAre(true, false));
  EXPECT_EQ(test.node.state(), NmtState::pre_operational);
}

TEST(Node, AnswersNothingButNmtInStopped) {
  NodeUnderTest test;
  test.receive("601#2B17100064000000");
  test.receive(kStop);
  EXPECT_THAT(test.receive("601#4000100000000000"), IsEmpty());
  EXPECT_THAT(test.receive("201#0600"), IsEmpty());
  EXPECT_THAT(test.host.accesses, IsEmpty());
  EXPECT_THAT(test.host.commands, IsEmpty());
  test.drive.status.error_code = 0x8611;
  EXPECT_THAT(test.update(), IsEmpty()) << "no emergency";
  EXPECT_THAT(test.advance(100ms), ElementsAre("701#04")) << "but its heartbeat";
}

TEST(Node, SendsAfterStoppedTheEmergencyThatCameInIt) {
  NodeUnderTest test;
  test.receive(kStop);
  test.drive.status.error_code = 0x8611;
  test.update();
  EXPECT_THAT(test.receive(kPreOperational), ElementsAre(StartsWith("081#1186")));
}

TEST(Node, SendsTheEmergencyOfAFaultThatIsThereAtItsStart) {
  FakeHost host;
  Node node({.node_id = 1}, host);
  DriveView drive;
  drive.status.error_code = 0x5530;
  node.start(drive, 0s);
  EXPECT_THAT(host.take(), ElementsAre("701#00", StartsWith("081#3055")));
}

TEST(Node, SendsTheEmergencyOfALastingFaultAgainAfterAResetOfTheCommunication) {
  NodeUnderTest test;
  test.drive.status.error_code = 0x8611;
  EXPECT_THAT(test.update(), ElementsAre(StartsWith("081#1186")));
  EXPECT_THAT(test.receive(kResetCommunication), ElementsAre("701#00"));
  EXPECT_THAT(test.update(), ElementsAre(StartsWith("081#1186")));
}

TEST(Node, SendsNoEarlierEmergencyAfterTheBootUpOfAResetNode) {
  NodeUnderTest test;
  test.drive.status.error_code = 0x8611;
  test.drive.status.fault_count = 1;
  test.update();
  EXPECT_THAT(test.receive(kResetNode), ElementsAre("701#00"));
  EXPECT_THAT(test.update(), IsEmpty()) << "the power cycle follows";
  EXPECT_THAT(test.receive(kResetCommunication), ElementsAre("701#00"));
  EXPECT_THAT(test.update(), IsEmpty()) << "still";
  test.drive.status = {};
  EXPECT_THAT(test.update(), IsEmpty()) << "no 0000h of a fault that was not sent";
  test.drive.status.error_code = 0x5530;
  test.drive.status.fault_count = 1;
  EXPECT_THAT(test.update(), ElementsAre(StartsWith("081#3055")));
}

TEST(Node, SendsTheEmergencyOfADriveThatIsThereAgainAfterAResetNode) {
  NodeUnderTest test;
  test.receive(kResetNode);
  test.drive.status.error_code = 0x5530;
  test.drive.status.fault_count = 1;
  test.node.start(test.drive, 0s);
  EXPECT_THAT(test.host.take(), ElementsAre("701#00", StartsWith("081#3055")));
}

TEST(Node, DropsASdoTransferWhenItIsStopped) {
  NodeUnderTest test;
  test.receive("601#4008100000000000");
  test.receive(kStop);
  EXPECT_THAT(test.advance(2s), IsEmpty()) << "no time-out";
  test.receive(kPreOperational);
  EXPECT_THAT(test.receive("601#6000000000000000"), ElementsAre("581#8000000001000405"));
}

TEST(Node, LeavesNodeGuardingUnanswered) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive("701#R"), IsEmpty());
}

TEST(Node, LeavesExtendedFramesUnanswered) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive("00000601#4000100000000000"), IsEmpty());
  EXPECT_THAT(test.receive("00000000#0101"), IsEmpty());
  EXPECT_EQ(test.node.state(), NmtState::pre_operational);
  EXPECT_EQ(test.node.counters().ignored_frames, 0U) << "CANopen has the base format only";
}

TEST(Node, IgnoresSdoFramesThatHaveNot8BytesAndCountsThem) {
  NodeUnderTest test;
  for (const char* const frame :
       {"601#", "601#40", "601#40001000", "601#40001000000000", "601#R"}) {
    EXPECT_THAT(test.receive(frame), IsEmpty()) << frame;
  }
  EXPECT_EQ(test.node.counters().ignored_frames, 5U);
  EXPECT_THAT(test.host.accesses, IsEmpty());
}

TEST(Node, IgnoresFramesWithTheIdentifiersThatItSends) {
  NodeUnderTest test;
  test.receive(kStart);
  for (const char* const frame : {"581#4000100000000000", "701#05", "081#1186210000000000"}) {
    EXPECT_THAT(test.receive(frame), IsEmpty()) << frame;
  }
}

TEST(Node, IgnoresSdoFramesOfOtherNodes) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive("602#4000100000000000"), IsEmpty());
  EXPECT_THAT(test.host.accesses, IsEmpty());
}

TEST(Node, SendsAHeartbeatAsSoonAsItsTimeIsWritten) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive("601#2B17100064000000"), ElementsAre("581#6017100000000000", "701#7F"));
  EXPECT_EQ(test.node.next_due(), DriveTime(100ms));
  test.receive(kStart);
  EXPECT_THAT(test.advance(100ms), Contains("701#05"));
}

TEST(Node, TellsTheEarliestTimeThatIsDue) {
  NodeUnderTest test;
  EXPECT_EQ(test.node.next_due(), std::nullopt);
  test.receive("601#2B171000DC050000");
  EXPECT_EQ(test.node.next_due(), DriveTime(1'500ms)) << "of the heartbeat";
  test.receive("601#4008100000000000");
  EXPECT_EQ(test.node.next_due(), DriveTime(1s)) << "of the SDO transfer";
  EXPECT_THAT(test.advance(1s), ElementsAre("581#8008100000000405"));
  EXPECT_EQ(test.node.counters().sdo_time_outs, 1U);
  EXPECT_EQ(test.node.next_due(), DriveTime(1'500ms));
}

TEST(Node, KeepsItsCountersOverAReset) {
  NodeUnderTest test;
  test.receive("601#6000000000000000");
  test.receive("601#40");
  test.receive(kResetNode);
  EXPECT_EQ(test.node.counters().sdo_aborts, 1U);
  EXPECT_EQ(test.node.counters().ignored_frames, 1U);
}

TEST(Node, CanBeMoved) {
  NodeUnderTest test;
  Node moved = std::move(test.node);
  moved.receive(frame_of(kStart), 0s);
  EXPECT_EQ(moved.state(), NmtState::operational);
  EXPECT_EQ(moved.id(), 1);
}

// --- PDOs ---

TEST(Node, PassesSetPointsOnInOperational) {
  NodeUnderTest test;
  test.receive(kStart);
  test.receive("201#0F00");
  ASSERT_EQ(test.host.commands.size(), 1U);
  EXPECT_THAT(test.host.commands[0], ElementsAre(DriveValue{{0x6040, 0}, 0x0F}));
}

TEST(Node, DropsPdosOutsideOfOperationalAndCountsThem) {
  NodeUnderTest test;
  test.receive("201#0F00");
  test.receive(kStop);
  test.receive("201#0F00");
  EXPECT_THAT(test.host.commands, IsEmpty());
  EXPECT_EQ(test.node.counters().dropped_pdos, 2U);
}

TEST(Node, IgnoresSetPointsWhileAnotherSessionOwnsTheAxisAndCountsThem) {
  NodeUnderTest test;
  test.receive(kStart);
  test.drive.is_owned = false;
  test.update();
  test.receive("201#0F00");
  EXPECT_THAT(test.host.commands, IsEmpty());
  EXPECT_EQ(test.node.counters().ignored_set_points, 1U);
  test.drive.is_owned = true;
  test.update();
  test.receive("201#0F00");
  EXPECT_EQ(test.host.commands.size(), 1U);
}

// RPDO1 and RPDO2 of type 1. RPDO1 is received twice before SYNC and RPDO2 once; SYNC would apply
// one of each.
TEST(Node, CountsEachSynchronousRpdoThatASyncWouldHaveLetAct) {
  NodeUnderTest test;
  test.receive("601#2F00140201000000");
  test.receive("601#2F01140201000000");
  test.receive(kStart);
  test.drive.is_owned = false;
  test.update();
  test.receive("201#0600");
  test.receive("201#0700");
  test.receive("301#070001");
  EXPECT_EQ(test.node.counters().ignored_set_points, 0U) << "they act at SYNC";
  test.receive("080#");
  EXPECT_EQ(test.node.counters().ignored_set_points, 2U);
  test.receive("080#");
  EXPECT_EQ(test.node.counters().ignored_set_points, 2U);
  EXPECT_THAT(test.host.commands, IsEmpty());
}

// 6041h = 0637h; without bit 9 (0200h) it is 0437h.
TEST(Node, ShowsRemoteAs0InPdosWhileAnotherSessionOwnsTheAxis) {
  NodeUnderTest test;
  test.drive.is_owned = false;
  test.update();
  EXPECT_THAT(test.receive(kStart), Contains("181#3704"));
  test.drive.is_owned = true;
  EXPECT_THAT(test.update(), Contains("181#3706"));
}

TEST(Node, SendsNoPdosOutsideOfOperational) {
  NodeUnderTest test;
  test.drive.status.ds402_statusword = 0x0237;
  EXPECT_THAT(test.update(), IsEmpty());
  test.receive(kStart);
  test.receive(kPreOperational);
  test.drive.status.ds402_statusword = 0x0637;
  EXPECT_THAT(test.update(), IsEmpty());
}

// 8210h, PDO not processed due to length error: generic and communication in 1001h.
TEST(Node, SendsTheEmergencyOfAPdoThatIsTooShort) {
  NodeUnderTest test;
  test.receive(kStart);
  EXPECT_THAT(test.receive("201#0F"), ElementsAre("081#1082113706000000"));
  EXPECT_EQ(test.node.counters().dropped_pdos, 1U);
}

/// A communication error: its causes and the frame that ends it.
struct CommunicationError {
  const char* code;  ///< in the byte order of frames
  std::vector<const char*> causes;
  const char* cure;
};

class CommunicationErrors : public testing::TestWithParam<CommunicationError> {};

// CiA 301, 7.2.7.1, 7.5.2.2 and 7.5.2.4. The drive itself reports no error.
TEST_P(CommunicationErrors, LastUntilARightFrameComesAndAreIn1001hAnd1003h) {
  const CommunicationError& error = GetParam();
  const std::string code = error.code;
  const auto error_register = [](NodeUnderTest& test) {
    test.receive("601#4001100000000000");
    return test.answer({.value = 0});
  };
  NodeUnderTest test;
  test.receive(kStart);
  for (const char* const cause : error.causes) test.receive(cause);
  test.advance(10ms);
  EXPECT_THAT(error_register(test), ElementsAre("581#4F01100011000000"));
  EXPECT_THAT(test.receive("601#4003100000000000"), ElementsAre("581#4F03100001000000"));
  EXPECT_THAT(test.receive("601#4003100100000000"), ElementsAre("581#43031001" + code + "0000"));
  EXPECT_THAT(test.receive("601#4003100200000000"), ElementsAre("581#8003100224000008"));
  EXPECT_THAT(test.receive(error.cure), ElementsAre("081#0000003706000000"));
  EXPECT_THAT(error_register(test), ElementsAre("581#4F01100000000000"));
  EXPECT_THAT(test.receive("601#4003100000000000"), ElementsAre("581#4F03100001000000"))
      << "the history stays";
  EXPECT_THAT(test.receive(error.cure), IsEmpty());
}

TEST_P(CommunicationErrors, AreSignalledWith1001hInByte2) {
  const CommunicationError& error = GetParam();
  NodeUnderTest test;
  test.receive(kStart);
  std::vector<std::string> frames;
  for (const char* const cause : error.causes) frames = test.receive(cause);
  if (frames.empty() || !frames.front().starts_with("081#")) frames = test.advance(10ms);
  EXPECT_THAT(frames, ElementsAre("081#" + std::string(error.code) + "113706000000"));
}

TEST_P(CommunicationErrors, EndWhereTheNodeHasNoPdos) {
  NodeUnderTest test;
  test.receive(kStart);
  for (const char* const cause : GetParam().causes) test.receive(cause);
  test.advance(10ms);
  EXPECT_THAT(test.receive(kPreOperational), ElementsAre("081#0000003706000000"));
}

// The third row writes 1400h:05 = 10 ms.
INSTANTIATE_TEST_SUITE_P(
    Node, CommunicationErrors,
    testing::Values(CommunicationError{"1082", {"201#0F"}, "201#0600"},
                    CommunicationError{"2082", {"201#060000"}, "201#0600"},
                    CommunicationError{"5082", {"601#2B0014050A000000", "201#0600"}, "201#0600"},
                    CommunicationError{"4082", {"080#01"}, "080#"}),
    [](const auto& row) {
      return "Code" + std::string(row.param.code);
    });

TEST(Node, ClearsTheHistoryOfItselfAndOfTheDriveWith0To1003h) {
  NodeUnderTest test;
  test.receive(kStart);
  test.receive("201#0F");
  test.receive("601#2F03100000000000");
  EXPECT_EQ(test.host.accesses.back().object, (ObjectAddress{0x1003, 0}));
  EXPECT_THAT(test.answer({.abort = AbortCode::refused_local_control}),
              Contains(StartsWith("581#80")));
  EXPECT_THAT(test.receive("601#4003100000000000"), ElementsAre("581#4F03100001000000"));
  test.receive("601#2F03100000000000");
  EXPECT_THAT(test.answer({}), ElementsAre("581#6003100000000000"));
  EXPECT_THAT(test.receive("601#4003100000000000"), ElementsAre("581#4F03100000000000"));
}

// --- SDO to the node's own objects ---

TEST(Node, AnswersItsOwnObjectsByItself) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive("601#4000120100000000"), ElementsAre("581#4300120101060000"));
  EXPECT_THAT(test.receive("601#4000120200000000"), ElementsAre("581#4300120281050000"));
  EXPECT_THAT(test.receive("601#4018100000000000"), ElementsAre("581#4F18100004000000"));
  EXPECT_THAT(test.receive("601#4014100000000000"), ElementsAre("581#4314100081000000"));
  EXPECT_THAT(test.receive("601#4000180100000000"), ElementsAre("581#4300180181010000"));
  EXPECT_THAT(test.host.accesses, IsEmpty());
}

TEST(Node, HasItsTextsFromItsSettings) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive("601#4008100000000000"), ElementsAre("581#4108100006000000"));
  EXPECT_THAT(test.receive("601#6000000000000000"), ElementsAre("581#0376647269766500"));
  EXPECT_THAT(test.receive("601#400A100000000000"), ElementsAre("581#410A100005000000"));
  EXPECT_THAT(test.receive("601#6000000000000000"), ElementsAre("581#05312E322E330000"));
  EXPECT_THAT(test.receive("601#4009100000000000"), ElementsAre("581#4109100001000000"));
  EXPECT_THAT(test.receive("601#6000000000000000"), ElementsAre("581#0D31000000000000"));
}

struct RefusedRow {
  const char* name;
  const char* request;
  const char* answer;
};

std::ostream& operator<<(std::ostream& stream, const RefusedRow& row) {
  return stream << row.name;
}

class RefusedAccess : public testing::TestWithParam<RefusedRow> {};

TEST_P(RefusedAccess, IsAnsweredWithItsAbortCodeAndReachesNobody) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive(GetParam().request), ElementsAre(GetParam().answer));
  EXPECT_THAT(test.host.accesses, IsEmpty());
  EXPECT_EQ(test.node.counters().sdo_aborts, 1U);
}

INSTANTIATE_TEST_SUITE_P(
    Each, RefusedAccess,
    testing::Values(
        RefusedRow{"UnknownIndex", "601#4000200000000000", "581#8000200000000206"},
        RefusedRow{"GuardTime", "601#400C100000000000", "581#800C100000000206"},
        RefusedRow{"LifeTimeFactor", "601#2F0D100001000000", "581#800D100000000206"},
        RefusedRow{"UnknownSubindex", "601#4040600100000000", "581#8040600111000906"},
        RefusedRow{"UnknownSubindexOfARecord", "601#4018100900000000", "581#8018100911000906"},
        RefusedRow{"WriteOfAConstant", "601#2F18100004000000", "581#8018100002000106"},
        RefusedRow{"WriteOfAText", "601#2308100041424344", "581#8008100002000106"},
        RefusedRow{"WriteOfAStatus", "601#2B41600000000000", "581#8041600002000106"},
        RefusedRow{"TooLong", "601#234060000F000000", "581#8040600012000706"},
        RefusedRow{"TooShort", "601#2B7A600000000000", "581#807A600013000706"},
        RefusedRow{"TooHigh", "601#2F29100103000000", "581#8029100131000906"},
        RefusedRow{"RestrictedCobId", "601#2314100081050000", "581#8014100030000906"},
        RefusedRow{"HeartbeatConsumerReserved", "601#23161001C8000901", "581#8016100130000906"}),
    [](const auto& row) {
      return std::string(row.param.name);
    });

TEST(Node, RefusesTheSameHeartbeatProducerTwice) {
  NodeUnderTest test;
  test.receive("601#23161001C8000900");
  EXPECT_THAT(test.receive("601#23161002C8000900"), ElementsAre("581#8016100243000406"));
}

TEST(Node, ReadsBackWhatWasWritten) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive("601#2B151000F4010000"), ElementsAre("581#6015100000000000"));
  EXPECT_THAT(test.receive("601#4015100000000000"), ElementsAre("581#4B151000F4010000"));
  test.receive("601#23161003C8000900");
  EXPECT_THAT(test.receive("601#4016100300000000"), ElementsAre("581#43161003C8000900"));
  test.receive("601#2F29100102000000");
  EXPECT_THAT(test.receive("601#4029100100000000"), ElementsAre("581#4F29100102000000"));
  test.receive("601#2F00180201000000");
  EXPECT_THAT(test.receive("601#4000180200000000"), ElementsAre("581#4F00180201000000"));
}

TEST(Node, GivesTheValueOfItsOwnNumbers) {
  NodeUnderTest test;
  EXPECT_EQ(test.node.value({0x1014, 0}), 0x81);
  EXPECT_EQ(test.node.value({0x1016, 0}), 4);
  EXPECT_EQ(test.node.value({0x1402, 1}), 0x401);
  EXPECT_EQ(test.node.value({0x1029, 1}), 0);
  EXPECT_EQ(test.node.value({0x1008, 0}), std::nullopt) << "a text";
  EXPECT_EQ(test.node.value({0x6041, 0}), std::nullopt) << "the drive's";
  EXPECT_EQ(test.node.value({0x2000, 0}), std::nullopt) << "no object";
}

TEST(Node, AnswersAReadOfEachObjectOfItsDictionary) {
  NodeUnderTest test;
  for (const NodeObject& object : node_objects()) {
    const std::string multiplexer = hex_digits(object.address.index & 0xFFU, 2) +
                                    hex_digits(object.address.index >> 8U, 2) +
                                    hex_digits(object.address.subindex, 2);
    const std::size_t begun = test.host.accesses.size();
    auto answers = test.receive("601#40" + multiplexer + "00000000");
    if (object.access == NodeAccess::write_only) {
      EXPECT_EQ(answers, std::vector{"581#80" + multiplexer + "01000106"}) << "write-only";
      continue;
    }
    const bool is_history = object.address.index == 0x1003;
    if (is_history && object.address.subindex > 0) {
      EXPECT_EQ(answers, std::vector{"581#80" + multiplexer + "24000008"}) << "it is empty";
      continue;
    }
    const bool is_drives = object.owner == ObjectOwner::drive && !is_history;
    EXPECT_EQ(test.host.accesses.size() - begun, is_drives ? 1U : 0U) << multiplexer;
    if (is_drives) answers = test.answer({.value = 1});
    ASSERT_EQ(answers.size(), 1U) << multiplexer;
    EXPECT_THAT(answers[0], StartsWith("581#4")) << "no abort";
    EXPECT_EQ(answers[0].substr(6, 6), multiplexer);
  }
}

// --- SDO to the drive ---

TEST(Node, ReadsAnObjectOfTheDriveByItsHost) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive("601#4041600000000000"), IsEmpty());
  ASSERT_EQ(test.host.accesses.size(), 1U);
  EXPECT_EQ(test.host.accesses[0].object, (ObjectAddress{0x6041, 0}));
  EXPECT_EQ(test.host.accesses[0].value, std::nullopt);
  EXPECT_THAT(test.answer({.value = 0x0650}), ElementsAre("581#4B41600050060000"));
}

TEST(Node, WritesAnObjectOfTheDriveByItsHost) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive("601#2B4060000F000000"), IsEmpty());
  ASSERT_EQ(test.host.accesses.size(), 1U);
  EXPECT_EQ(test.host.accesses[0].object, (ObjectAddress{0x6040, 0}));
  EXPECT_EQ(test.host.accesses[0].value, 0x0F);
  EXPECT_THAT(test.answer({}), ElementsAre("581#6040600000000000"));
}

TEST(Node, PassesOnTheAbortCodeOfTheDrive) {
  NodeUnderTest test;
  test.receive("601#2B4060000F000000");
  EXPECT_THAT(test.answer({.abort = AbortCode::refused_local_control}),
              ElementsAre("581#8040600021000008"));
}

TEST(Node, WritesNumbersWithTheSignOfTheirType) {
  NodeUnderTest test;
  test.receive("601#237A6000FBFFFFFF");
  EXPECT_EQ(test.host.accesses.back().value, -5) << "INTEGER32";
  test.answer({});
  test.receive("601#2F606000FF000000");
  EXPECT_EQ(test.host.accesses.back().value, -1) << "INTEGER8";
  test.answer({});
  test.receive("601#2B4060000FFF0000");
  EXPECT_EQ(test.host.accesses.back().value, 0xFF0F) << "UNSIGNED16";
  test.answer({});
  test.receive("601#23816000FFFFFFFF");
  EXPECT_EQ(test.host.accesses.back().value, 0xFFFF'FFFF) << "UNSIGNED32";
}

TEST(Node, ReadsNumbersWithTheSignOfTheirType) {
  NodeUnderTest test;
  test.receive("601#4064600000000000");
  EXPECT_THAT(test.answer({.value = -5}), ElementsAre("581#43646000FBFFFFFF"));
  test.receive("601#4061600000000000");
  EXPECT_THAT(test.answer({.value = -1}), ElementsAre("581#4F616000FF000000"));
}

TEST(Node, WritesAnObjectOfTheDriveBySegmentsToo) {
  NodeUnderTest test;
  test.receive("601#217A600004000000");
  EXPECT_THAT(test.receive("601#07FBFFFFFF000000"), IsEmpty());
  EXPECT_EQ(test.host.accesses.back().value, -5);
  EXPECT_THAT(test.answer({}), ElementsAre("581#2000000000000000"));
}

TEST(Node, ShowsRemoteAs0BySdoWhileAnotherSessionOwnsTheAxis) {
  NodeUnderTest test;
  test.drive.is_owned = false;
  test.update();
  test.receive("601#4041600000000000");
  EXPECT_THAT(test.answer({.value = 0x0637}), ElementsAre("581#4B41600037040000"));
}

TEST(Node, WritesTheControlwordAlsoWhileAnotherSessionOwnsTheAxis) {
  NodeUnderTest test;
  test.drive.is_owned = false;
  test.update();
  test.receive("601#2B4060000F000000");
  EXPECT_EQ(test.host.accesses.size(), 1U) << "the bench refuses it";
}

TEST(Node, HasOneAccessUnderWay) {
  NodeUnderTest test;
  test.receive("601#4041600000000000");
  test.receive("601#4064600000000000");
  EXPECT_EQ(test.host.accesses.size(), 1U);
  EXPECT_THAT(test.answer({.value = 1}), ElementsAre("581#4B41600001000000"));
  EXPECT_EQ(test.host.accesses.size(), 2U);
  EXPECT_THAT(test.answer({.value = 2}), ElementsAre("581#4364600002000000"));
}

TEST(Node, HasOneAccessUnderWayOverAResetToo) {
  NodeUnderTest test;
  test.receive("601#4041600000000000");
  test.receive(kResetNode);
  EXPECT_THAT(test.receive("601#4064600000000000"), IsEmpty());
  EXPECT_EQ(test.host.accesses.size(), 1U);
  EXPECT_THAT(test.answer({.value = 1}), IsEmpty()) << "nobody waits for it any more";
  EXPECT_EQ(test.host.accesses.size(), 2U);
  EXPECT_THAT(test.answer({.value = 2}), ElementsAre("581#4364600002000000"));
}

TEST(Node, IgnoresAnAnswerWithAnOldTicket) {
  NodeUnderTest test;
  test.receive("601#4041600000000000");
  const std::uint32_t old = test.host.accesses.back().ticket;
  test.answer({.value = 1});
  test.receive("601#4064600000000000");
  test.node.complete(old, {.value = 7}, test.now);
  EXPECT_THAT(test.host.take(), IsEmpty());
  EXPECT_THAT(test.answer({.value = 2}), ElementsAre("581#4364600002000000"));
}

TEST(Node, ForgetsAnAccessWhenTheDriveIsThereAgain) {
  NodeUnderTest test;
  test.receive("601#4041600000000000");
  test.node.start(test.drive, 0s);
  test.host.take();
  test.receive("601#4064600000000000");
  EXPECT_EQ(test.host.accesses.size(), 2U);
  test.node.complete(test.host.accesses[0].ticket, {.value = 1}, 0s);
  EXPECT_THAT(test.host.take(), IsEmpty());
  EXPECT_THAT(test.answer({.value = 2}), ElementsAre("581#4364600002000000"));
}

// --- 1010h and 1011h ---

TEST(NodeParameters, AreStoredWhenTheDriveHasSavedItsOwn) {
  NodeUnderTest test;
  test.receive("601#2B171000F4010000");
  test.receive(kSave);
  EXPECT_EQ(test.host.accesses.back().object, (ObjectAddress{0x1010, 1}));
  EXPECT_EQ(test.host.accesses.back().value, 0x6576'6173);
  EXPECT_THAT(test.node.stored(), IsEmpty()) << "not yet";
  EXPECT_THAT(test.answer({}), ElementsAre("581#6010100100000000"));
  EXPECT_THAT(test.node.stored(), ElementsAre(Pair(ObjectAddress{0x1017, 0}, 500U)));
}

TEST(NodeParameters, AreNotStoredWhenTheDriveRefuses) {
  NodeUnderTest test;
  test.receive("601#2B171000F4010000");
  test.receive(kSave);
  EXPECT_THAT(test.answer({.abort = AbortCode::hardware_error}),
              ElementsAre("581#8010100100000606"));
  EXPECT_THAT(test.node.stored(), IsEmpty());
}

TEST(NodeParameters, AreStoredAlsoWhenTheClientHasAborted) {
  NodeUnderTest test;
  test.receive("601#2B171000F4010000");
  test.receive(kSave);
  test.receive("601#8010100100000405");
  EXPECT_THAT(test.answer({}), IsEmpty());
  EXPECT_THAT(test.node.stored(), Not(IsEmpty())) << "the drive has saved its own";
}

TEST(NodeParameters, AreStoredAsTheyWereAtTheRequestWhenAResetComesBeforeTheAnswer) {
  for (const char* const reset : {kResetCommunication, kResetNode}) {
    NodeUnderTest test;
    test.receive("601#2B171000F4010000");
    test.receive(kSave);
    test.receive(reset);
    EXPECT_EQ(test.node.value({0x1017, 0}), 0) << reset << ": nothing was stored yet";
    EXPECT_THAT(test.answer({}), IsEmpty()) << reset << ": nobody waits for it any more";
    EXPECT_THAT(test.node.stored(), ElementsAre(Pair(ObjectAddress{0x1017, 0}, 500U))) << reset;
  }
}

TEST(NodeParameters, CountTheirChanges) {
  NodeUnderTest test;
  const std::uint64_t before = test.node.parameter_changes();
  for (const char* const frame : {kStart, kPreOperational, kStop, kStart, "601#4000140100000000"}) {
    test.receive(frame);
    EXPECT_EQ(test.node.parameter_changes(), before) << frame;
  }
  test.receive("601#2B171000F4010000");
  const std::uint64_t written = test.node.parameter_changes();
  EXPECT_NE(written, before);
  test.receive(kResetCommunication);
  EXPECT_NE(test.node.parameter_changes(), written);
}

TEST(NodeParameters, AreHandedOverBeforeTheAnswer) {
  NodeUnderTest test;
  test.receive("601#2B171000F4010000");
  test.receive(kSave);
  EXPECT_THAT(test.host.stored, IsEmpty()) << "the drive first";
  test.node.complete(test.host.accesses.back().ticket, {}, test.now);
  EXPECT_THAT(test.host.stored, ElementsAre(Node::Parameters{{ObjectAddress{0x1017, 0}, 500U}}));
  test.receive(kLoad);
  test.node.complete(test.host.accesses.back().ticket, {}, test.now);
  ASSERT_EQ(test.host.stored.size(), 2U);
  EXPECT_THAT(test.host.stored[1], IsEmpty());
}

// 06060000h: access failed due to a hardware error (CiA 301, table 22).
TEST(NodeParameters, AreLeftAsTheyWereWhenTheyCannotBeWritten) {
  NodeUnderTest test(Node::Parameters{{{0x1017, 0}, 100}});
  test.host.can_store = false;
  test.receive("601#2B171000F4010000");
  test.receive(kSave);
  EXPECT_THAT(test.answer({}), ElementsAre("581#8010100100000606"));
  test.receive(kLoad);
  EXPECT_THAT(test.answer({}), ElementsAre("581#8011100100000606"));
  EXPECT_THAT(test.node.stored(), ElementsAre(Pair(ObjectAddress{0x1017, 0}, 100U)));
}

TEST(NodeParameters, AreNotStoredByARead) {
  NodeUnderTest test;
  test.receive("601#2B171000F4010000");
  test.receive("601#4010100100000000");
  EXPECT_THAT(test.answer({.value = 1}), ElementsAre("581#4310100101000000"));
  EXPECT_THAT(test.node.stored(), IsEmpty());
}

TEST(NodeParameters, HaveTheirDefaultsAfterAResetWhenTheyWereNotStored) {
  for (const char* const reset : {kResetCommunication, kResetNode}) {
    NodeUnderTest test;
    test.receive("601#2B171000F4010000");
    test.receive("601#2F29100102000000");
    test.receive(reset);
    EXPECT_EQ(test.node.value({0x1017, 0}), 0) << reset;
    EXPECT_EQ(test.node.value({0x1029, 1}), 0) << reset;
    EXPECT_EQ(test.node.next_due(), std::nullopt) << reset;
  }
}

TEST(NodeParameters, AreInForceAgainAfterAResetWhenTheyWereStored) {
  NodeUnderTest test;
  test.receive("601#2B171000F4010000");
  test.receive(kSave);
  test.answer({});
  test.receive("601#2B17100000000000");
  EXPECT_EQ(test.node.next_due(), std::nullopt);
  EXPECT_THAT(test.receive(kResetCommunication), ElementsAre("701#00"));
  EXPECT_EQ(test.node.value({0x1017, 0}), 500);
  EXPECT_EQ(test.node.next_due(), DriveTime(500ms)) << "the boot-up is the first heartbeat";
}

TEST(NodeParameters, AreInForceFromTheStartWhenTheyWereStored) {
  NodeUnderTest test(Node::Parameters{{{0x1017, 0}, 500}, {{0x1029, 1}, 1}, {{0x1014, 0}, 0xA1}});
  EXPECT_EQ(test.node.value({0x1017, 0}), 500);
  EXPECT_EQ(test.node.value({0x1029, 1}), 1);
  EXPECT_EQ(test.node.value({0x1014, 0}), 0xA1);
}

TEST(NodeParameters, HaveTheirDefaultsAfterTheResetThatFollowsALoad) {
  NodeUnderTest test(Node::Parameters{{{0x1017, 0}, 500}});
  test.receive(kLoad);
  EXPECT_EQ(test.host.accesses.back().object, (ObjectAddress{0x1011, 1}));
  EXPECT_THAT(test.answer({}), ElementsAre("581#6011100100000000"));
  EXPECT_THAT(test.node.stored(), IsEmpty());
  EXPECT_EQ(test.node.value({0x1017, 0}), 500) << "until then they are in force";
  test.receive(kResetCommunication);
  EXPECT_EQ(test.node.value({0x1017, 0}), 0);
}

TEST(NodeParameters, OfPdosAreStoredAndInForceAgain) {
  NodeUnderTest test;
  for (const char* const write :
       {"601#2300180181010080", "601#2F001A0000000000", "601#23001A0220006460",
        "601#2F001A0002000000", "601#2F00180201000000", "601#23001801A1010000"}) {
    EXPECT_THAT(test.receive(write), ElementsAre(StartsWith("581#60"))) << write;
  }
  test.receive(kSave);
  test.answer({});
  const Node::Parameters stored{
      {{0x1800, 1}, 0x1A1}, {{0x1800, 2}, 1}, {{0x1A00, 0}, 2}, {{0x1A00, 2}, 0x6064'0020}};
  EXPECT_EQ(test.node.stored(), stored);
  NodeUnderTest next(stored);
  for (const auto& [object, value] : stored) EXPECT_EQ(next.node.value(object), value);
  next.receive(kStart);
  EXPECT_THAT(next.receive("080#"), Contains("1A1#370600000000")) << "6041h and 6064h, at SYNC";
}

TEST(NodeParameters, ThatAreRefusedAtTheStartKeepTheirDefaults) {
  NodeUnderTest test(Node::Parameters{{{0x1014, 0}, 0x581},
                                      {{0x1016, 1}, 0xFF09'00C8},
                                      {{0x1017, 0}, 0x1'0000},
                                      {{0x1029, 1}, 9},
                                      {{0x1015, 0}, 100}});
  EXPECT_EQ(test.node.value({0x1014, 0}), 0x81);
  EXPECT_EQ(test.node.value({0x1016, 1}), 0);
  EXPECT_EQ(test.node.value({0x1017, 0}), 0);
  EXPECT_EQ(test.node.value({0x1029, 1}), 0);
  EXPECT_EQ(test.node.value({0x1015, 0}), 100);
}

// --- 1020h ---

constexpr const char* kWriteDate = "601#2320100110270000";  // 10,000 days
constexpr const char* kWriteHeartbeat = "601#2B171000F4010000";

TEST(VerifyConfiguration, IsZeroUntilItIsWritten) {
  NodeUnderTest test;
  EXPECT_THAT(test.receive("601#4020100000000000"), ElementsAre("581#4F20100002000000"));
  EXPECT_EQ(test.node.value({0x1020, 1}), 0);
  EXPECT_EQ(test.node.value({0x1020, 2}), 0);
}

// A configuration tool writes objects in ascending order, so some follow 1020h, and then saves all.
TEST(VerifyConfiguration, IsSavedWithTheConfigurationThatItIsWrittenWith) {
  NodeUnderTest test;
  test.receive(kWriteDate);
  test.receive("601#2320100215CD5B07");
  test.receive("601#2F00180201000000");
  test.receive(kSave);
  test.answer({});
  EXPECT_EQ(test.node.stored().at({0x1020, 1}), 10'000U);
  test.receive(kResetCommunication);
  EXPECT_EQ(test.node.value({0x1020, 1}), 10'000);
  EXPECT_EQ(test.node.value({0x1020, 2}), 123'456'789);
}

TEST(VerifyConfiguration, IsZeroWhenAnotherConfigurationIsSavedWithoutIt) {
  for (const char* const change : {kWriteHeartbeat, "601#2381600001000000"}) {
    NodeUnderTest test(Node::Parameters{{{0x1020, 1}, 10'000}});
    EXPECT_EQ(test.node.value({0x1020, 1}), 10'000);
    test.receive(change);
    if (!test.host.accesses.empty()) test.answer({});  // 6081h: the drive accepts it
    EXPECT_EQ(test.node.value({0x1020, 1}), 10'000) << "it is that of the next power-up";
    test.receive(kSave);
    test.answer({});
    EXPECT_EQ(test.node.value({0x1020, 1}), 0) << change;
    EXPECT_EQ(test.node.stored().count({0x1020, 1}), 0U) << change;
  }
}

TEST(VerifyConfiguration, StaysWhenTheSameIsSavedOnceMore) {
  NodeUnderTest test(Node::Parameters{{{0x1020, 1}, 10'000}});
  test.receive("601#2B40600006000000");  // 6040h is not saved
  test.answer({});
  test.receive(kSave);
  test.answer({});
  EXPECT_EQ(test.node.stored().at({0x1020, 1}), 10'000U);
}

TEST(VerifyConfiguration, StaysWhenTheDriveCannotSave) {
  NodeUnderTest test(Node::Parameters{{{0x1020, 1}, 10'000}});
  test.receive(kWriteHeartbeat);
  test.receive(kSave);
  test.answer({.abort = AbortCode::cannot_store_or_transfer});
  EXPECT_EQ(test.node.value({0x1020, 1}), 10'000);
}

TEST(VerifyConfiguration, ForgetsADateThatWasNotSavedWithAReset) {
  NodeUnderTest test(Node::Parameters{{{0x1020, 1}, 10'000}});
  test.receive("601#2320100111270000");
  test.receive(kResetCommunication);
  EXPECT_EQ(test.node.value({0x1020, 1}), 10'000);
  test.receive(kWriteHeartbeat);
  test.receive(kSave);
  test.answer({});
  EXPECT_EQ(test.node.value({0x1020, 1}), 0);
}

// --- bus-off ---

TEST(NodeBusOff, IsAnErrorOfTheCommunicationAsIn1029h) {
  struct Row {
    const char* behaviour;
    NmtState state;
  };

  for (const Row& row : {Row{"601#2F29100100000000", NmtState::pre_operational},
                         Row{"601#2F29100101000000", NmtState::operational},
                         Row{"601#2F29100102000000", NmtState::stopped}}) {
    NodeUnderTest test;
    test.receive(row.behaviour);
    test.receive(kStart);
    test.host.connection_lost.clear();
    test.node.set_bus_off(true, test.now);
    EXPECT_EQ(test.node.state(), row.state) << row.behaviour;
    EXPECT_THAT(test.host.connection_lost, ElementsAre(true));
    test.host.take();
    test.node.set_bus_off(false, test.now);
    EXPECT_EQ(test.host.take().empty(), row.state == NmtState::stopped) << "no EMCY in Stopped";
    EXPECT_THAT(test.host.connection_lost, ElementsAre(true, false));
  }
}

TEST(NodeBusOff, IsReportedWithEmergency8140AtItsEnd) {
  NodeUnderTest test;
  test.node.set_bus_off(true, test.now);
  EXPECT_THAT(test.host.take(), IsEmpty());
  test.node.set_bus_off(false, test.now);
  EXPECT_THAT(test.host.take(), Contains(StartsWith("081#4081")));
}

TEST(NodeBusOff, IsOverWhenItIsReported) {
  NodeUnderTest test;
  test.node.set_bus_off(true, test.now);
  test.node.set_bus_off(false, test.now);
  EXPECT_THAT(test.host.take(), ElementsAre(StartsWith("081#408111"), StartsWith("081#000000")));
}

// --- any frames ---

/// Mostly frames that concern node 1, and requests for objects that exist.
rc::Gen<Frame> any_frame() {
  using Bytes = std::array<std::uint8_t, kMostData>;
  const auto id = rc::gen::weightedOneOf<std::uint32_t>(
      {{8, rc::gen::just<std::uint32_t>(0x601)},
       {2,
        rc::gen::elementOf(std::vector<std::uint32_t>{0x000, 0x080, 0x081, 0x181, 0x201, 0x301,
                                                      0x401, 0x501, 0x581, 0x602, 0x701, 0x709})},
       {1, rc::gen::inRange<std::uint32_t>(0, 0x800)}});
  const auto command = rc::gen::elementOf(std::vector<std::uint8_t>{
      0x40, 0x40, 0x22, 0x23, 0x2B, 0x2F, 0x20, 0x21, 0x00, 0x10, 0x01, 0x60, 0x70, 0xE0});
  // Any object, independent of rapidcheck's size parameter.
  const auto place = rc::gen::resize(100, rc::gen::inRange<std::size_t>(0, node_objects().size()));
  return rc::gen::map(
      rc::gen::tuple(id, command, place, rc::gen::arbitrary<Bytes>(),
                     rc::gen::resize(100, rc::gen::inRange<unsigned>(0, 100))),
      [](const auto& parts) {
        const ObjectAddress object = node_objects()[std::get<2>(parts)].address;
        const unsigned kind = std::get<4>(parts);
        Frame frame{.id = std::get<0>(parts), .size = kMostData, .data = std::get<3>(parts)};
        frame.is_remote = kind == 0;
        frame.is_extended = kind == 1;
        if (kind < 10) frame.size = static_cast<std::uint8_t>(kind % 9);
        // No block transfer: it has requests without a response and responses of several frames.
        if (frame.data[0] >> 5U == 5 || frame.data[0] >> 5U == 6) frame.data[0] = 0x40;
        if (kind < 30) return frame;
        frame.data[0] = std::get<1>(parts);
        frame.data[1] = static_cast<std::uint8_t>(object.index & 0xFFU);
        frame.data[2] = static_cast<std::uint8_t>(object.index >> 8U);
        frame.data[3] = object.subindex;
        if (frame.id == 0) frame = {.size = 2, .data = {0x01, 0x01}};
        return frame;
      });
}

bool is_sdo_request(const Frame& frame) {
  return !frame.is_remote && !frame.is_extended && frame.id == 0x601 && frame.size == kMostData &&
         frame.data[0] >> 5U != 4;
}

std::size_t count_responses(const std::vector<std::string>& frames) {
  std::size_t count = 0;
  for (const std::string& frame : frames) count += frame.starts_with("581#") ? 1U : 0U;
  return count;
}

void set_up_rapidcheck() {
  const std::uint64_t cases = test::case_count(1'000, 50'000);
  setenv("RC_PARAMS", ("max_size=80 max_success=" + std::to_string(cases)).c_str(), 0);
}

TEST(NodeProperty, EachCompleteSdoRequestOutsideOfStoppedGetsOneResponseAtOnce) {
  set_up_rapidcheck();
  const bool holds = rc::check("one response for each request, none for any other frame", [] {
    const auto frames = *rc::gen::container<std::vector<Frame>>(any_frame());
    NodeUnderTest test;
    for (const Frame& frame : frames) {
      const bool is_served = test.node.state() != NmtState::stopped;
      const std::size_t begun = test.host.accesses.size();
      test.node.receive(frame, test.now);
      std::size_t responses = count_responses(test.host.take());
      if (test.host.accesses.size() != begun) responses += count_responses(test.answer({}));
      RC_ASSERT(responses == (is_served && is_sdo_request(frame) ? 1U : 0U));
    }
  });
  EXPECT_TRUE(holds);
}

// The drive answers late, so some requests wait. NMT commands are left out, because requests that
// wait at a stop or a reset are not answered.
TEST(NodeProperty, EachCompleteSdoRequestGetsOneResponseWhenTheDriveAnswersLate) {
  set_up_rapidcheck();
  const bool holds = rc::check("as many responses as requests", [] {
    const auto frames = *rc::gen::container<std::vector<Frame>>(any_frame());
    const auto delay = *rc::gen::inRange<std::size_t>(1, 30);
    NodeUnderTest test;
    std::size_t requests = 0;
    std::size_t responses = 0;
    std::size_t answered = 0;
    std::size_t received = 0;
    for (const Frame& frame : frames) {
      if (frame.id == 0 || (frame.id == 0x601 && frame.data[0] >> 5U == 4)) continue;
      requests += is_sdo_request(frame) ? 1U : 0U;
      test.node.receive(frame, test.now);
      responses += count_responses(test.host.take());
      ++received;
      if (received % delay == 0 && answered < test.host.accesses.size()) {
        ++answered;
        responses += count_responses(test.answer({}));
      }
      RC_ASSERT(test.host.accesses.size() <= answered + 1);
    }
    while (answered < test.host.accesses.size()) {
      ++answered;
      responses += count_responses(test.answer({}));
    }
    RC_ASSERT(responses == requests);
  });
  EXPECT_TRUE(holds);
}

TEST(NodeProperty, NothingIsDueAnyMoreOnceTheNodeHasAdvancedToIt) {
  set_up_rapidcheck();
  const bool holds = rc::check("next_due() lies behind the time of advance()", [] {
    const auto frames = *rc::gen::container<std::vector<Frame>>(any_frame());
    const auto step = *rc::gen::inRange(1, 2'000'000);
    NodeUnderTest test;
    for (const Frame& frame : frames) {
      test.node.receive(frame, test.now);
      test.advance(test.now + DriveTime{step});
      const auto due = test.node.next_due();
      RC_ASSERT((!due || *due > test.now));  // the macro evaluates both sides of ||
    }
  });
  EXPECT_TRUE(holds);
}

}  // namespace
}  // namespace vdrive::canopen
