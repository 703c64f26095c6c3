// SPDX-License-Identifier: Apache-2.0
// Unit tests of the emergency producer (CiA 301, 7.2.7). The COB-ID of node 1 is 081h.
#include "node/emergency.hpp"

#include "canopen/fake_host.hpp"
#include "vdrive/cia402/error_code.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// A drive in profile position mode without a fault, whose node may send emergencies.
struct EmergencyUnderTest {
  FakeHost host;
  Emergency emergency{1, host};
  AxisStatus drive;

  EmergencyUnderTest() {
    drive.ds402_statusword = 0x0637;
    drive.op_mode_actual = 1;
    emergency.set_allowed(true, 0s);
  }

  /// Sets a fault in the drive's status.
  std::vector<std::string> fault(std::uint16_t code, std::uint8_t error_register,
                                 DriveTime now = 0s) {
    drive.error_code = code;
    drive.error_register = error_register;
    drive.ds402_statusword = 0x0208;
    ++drive.fault_count;
    return update(now);
  }

  /// Resets the fault.
  std::vector<std::string> reset(DriveTime now = 0s) {
    drive.error_code = 0;
    drive.error_register = 0;
    drive.ds402_statusword = 0x0250;
    return update(now);
  }

  std::vector<std::string> update(DriveTime now = 0s) {
    emergency.update(drive, now);
    return host.take();
  }

  std::vector<std::string> advance(DriveTime now) {
    emergency.advance(now);
    return host.take();
  }
};

// --- after NMT reset node: the drive restarts later ---

TEST(Emergency, LeavesOutTheFaultOfADriveThatHasNotRestartedYet) {
  EmergencyUnderTest node;
  node.fault(0x8611, 0x21);
  node.emergency.reset();
  node.emergency.await_restart(node.drive, 0s);
  node.emergency.set_allowed(true, 0s);
  EXPECT_THAT(node.update(1ms), IsEmpty()) << "the old fault";
  node.drive.fault_count = 0;
  EXPECT_THAT(node.reset(2ms), IsEmpty()) << "nothing was sent whose end would be";
  EXPECT_THAT(node.fault(0x8611, 0x21, 3ms), SizeIs(1)) << "of the restarted drive";
}

// 6007h = 1: a drive in Operation enabled enters fault 8130h before it is switched off.
TEST(Emergency, LeavesOutTheFaultThatTheResetItselfCausesInTheDrive) {
  EmergencyUnderTest node;
  node.emergency.reset();
  node.emergency.await_restart(node.drive, 0s);
  node.emergency.set_allowed(true, 0s);
  EXPECT_THAT(node.update(1ms), IsEmpty()) << "still in Operation enabled";
  EXPECT_THAT(node.fault(0x8130, 0x11, 2ms), IsEmpty());
  node.drive.fault_count = 0;
  EXPECT_THAT(node.reset(3ms), IsEmpty());
}

TEST(Emergency, IsSentForAFaultThatARestartedDriveHasAtOnce) {
  EmergencyUnderTest node;
  node.fault(0x8611, 0x21);
  node.fault(0x5530, 0x81);
  node.emergency.reset();
  node.emergency.await_restart(node.drive, 0s);
  node.emergency.set_allowed(true, 0s);
  node.drive.fault_count = 0;
  EXPECT_THAT(node.fault(0x5530, 0x81, 1ms), SizeIs(1)) << "fewer faults than before: 1, not 2";
}

TEST(Emergency, IsSentForTheFaultOfADriveThatDoesNotRestart) {
  EmergencyUnderTest node;
  node.fault(0x8611, 0x21);
  node.emergency.reset();
  node.emergency.await_restart(node.drive, 5ms);
  node.emergency.set_allowed(true, 5ms);
  EXPECT_THAT(node.update(1004ms), IsEmpty());
  EXPECT_THAT(node.update(1005ms), ElementsAre("081#1186210802010100"));
  EXPECT_THAT(node.reset(1006ms), SizeIs(1));
}

TEST(Emergency, OfTheCommunicationIsSentAlsoWhileTheDriveRestarts) {
  EmergencyUnderTest node;
  node.fault(0x8611, 0x21);
  node.emergency.reset();
  node.emergency.await_restart(node.drive, 0s);
  node.emergency.set_allowed(true, 0s);
  node.update(1ms);
  node.emergency.begin_error(0x8210, 1ms);
  EXPECT_THAT(node.host.take(), SizeIs(1));
}

// 8611h, 1001h = 21h, 6041h = 0208h, mode 1, first fault, no producer.
TEST(Emergency, HasCodeErrorRegisterStatuswordModeAndNumberOfTheFault) {
  EmergencyUnderTest node;
  EXPECT_THAT(node.fault(0x8611, 0x21), ElementsAre("081#1186210802010100"));
}

TEST(Emergency, IsSentForEachFaultOfTheDriveWithItsCode) {
  for (const ErrorCode code : error_codes()) {
    EmergencyUnderTest node;
    const auto number = static_cast<std::uint16_t>(code);
    const std::string bytes = hex_digits(number & 0xFFU, 2) + hex_digits(number >> 8U, 2) +
                              hex_digits(error_register_of(code), 2);
    EXPECT_THAT(node.fault(number, error_register_of(code)),
                ElementsAre("081#" + bytes + "0802010100"));
  }
}

TEST(Emergency, IsNotSentWithoutAFault) {
  EmergencyUnderTest node;
  EXPECT_THAT(node.update(), IsEmpty());
}

TEST(Emergency, IsSentOnceAFault) {
  EmergencyUnderTest node;
  node.fault(0x8611, 0x21);
  EXPECT_THAT(node.update(1s), IsEmpty());
}

TEST(Emergency, IsTheErrorReset0000WhenTheFaultHasBeenReset) {
  EmergencyUnderTest node;
  node.fault(0x8611, 0x21);
  EXPECT_THAT(node.reset(), ElementsAre("081#0000005002010100"));
  EXPECT_THAT(node.update(), IsEmpty());
}

TEST(Emergency, IsSentAgainForTheSameFaultAfterAReset) {
  EmergencyUnderTest node;
  node.fault(0x8611, 0x21);
  node.reset();
  EXPECT_THAT(node.fault(0x8611, 0x21), ElementsAre("081#1186210802010200"));
}

TEST(Emergency, IsSentForAFaultThatFollowsItsResetWithinATick) {
  EmergencyUnderTest node;
  node.fault(0x4310, 0x09);
  EXPECT_THAT(node.fault(0x4310, 0x09), ElementsAre("081#1043090802010200"));
}

TEST(Emergency, IsSentForAnotherFaultInAFault) {
  EmergencyUnderTest node;
  node.fault(0x8611, 0x21);
  EXPECT_THAT(node.fault(0x4310, 0x29), ElementsAre("081#1043290802010200"));
}

TEST(Emergency, OfTheCommunicationSetsItsBitsUntilItIsOver) {
  EmergencyUnderTest node;
  node.update();
  node.emergency.begin_error(0x8210, 0s);
  EXPECT_THAT(node.host.take(), ElementsAre("081#1082113706010000"));
  EXPECT_EQ(node.emergency.error_register(), 0x11);
  EXPECT_THAT(node.update(1s), IsEmpty());
  node.emergency.end_errors(2s);
  EXPECT_THAT(node.host.take(), ElementsAre("081#0000003706010000"));
  EXPECT_EQ(node.emergency.error_register(), 0);
  node.emergency.end_errors(3s);
  EXPECT_THAT(node.host.take(), IsEmpty()) << "it was over";
}

// CiA 301, 7.2.7.1: the state is error free only without any error.
TEST(Emergency, OfTheCommunicationIsOverWhenTheLastOneIs) {
  EmergencyUnderTest node;
  node.fault(0x2310, 0x03);
  node.emergency.begin_heartbeat_error(9, 0s);
  node.emergency.begin_error(0x8210, 0s);
  node.host.take();
  node.emergency.end_errors(1s);
  EXPECT_THAT(node.host.take(), IsEmpty());
  EXPECT_THAT(node.reset(2s), ElementsAre("081#0000115002010100")) << "a reset is always told";
  node.emergency.end_heartbeat_error(3s);
  EXPECT_THAT(node.host.take(), ElementsAre("081#0000005002010100"));
}

// ---- 1003h

TEST(Emergency, IsInTheHistoryNewestFirstWithoutErrorResets) {
  EmergencyUnderTest node;
  node.fault(0x8611, 0x21);
  node.emergency.begin_error(0x8210, 0s);
  node.reset();
  node.emergency.end_errors(0s);
  node.emergency.begin_heartbeat_error(9, 0s);
  node.fault(0x8130, 0x11);  // the drive's reaction to it
  EXPECT_THAT(node.emergency.history(), ElementsAre(0x8130, 0x8210, 0x8611));
  node.emergency.clear_history();
  EXPECT_THAT(node.emergency.history(), IsEmpty());
}

TEST(Emergency, LeavesTheNewestEightInTheHistory) {
  EmergencyUnderTest node;
  for (std::uint16_t code = 0x8201; code <= 0x8209; ++code) node.emergency.begin_error(code, 0s);
  EXPECT_THAT(node.emergency.history(),
              ElementsAre(0x8209, 0x8208, 0x8207, 0x8206, 0x8205, 0x8204, 0x8203, 0x8202));
}

TEST(Emergency, IsInTheHistoryAlsoWhereItsMessageIsSwitchedOff) {
  EmergencyUnderTest node;
  ASSERT_EQ(node.emergency.set_cob_id(0x8000'0081), AbortCode::none);
  node.fault(0x8611, 0x21);
  EXPECT_THAT(node.emergency.history(), ElementsAre(0x8611));
}

TEST(Emergency, HasNoHistoryOnceTheDriveWasSwitchedOff) {
  EmergencyUnderTest by_master;
  by_master.fault(0x8611, 0x21);
  by_master.emergency.await_restart(by_master.drive, 0s);
  EXPECT_THAT(by_master.emergency.history(), IsEmpty());
  EmergencyUnderTest by_others;
  by_others.fault(0x8611, 0x21);
  by_others.drive.fault_count = 0;
  by_others.reset();
  EXPECT_THAT(by_others.emergency.history(), IsEmpty());
}

TEST(Emergency, OfTheCommunicationShowsAFaultOfTheDriveToo) {
  EmergencyUnderTest node;
  node.fault(0x2310, 0x03);
  node.emergency.begin_error(0x8220, 0s);
  EXPECT_THAT(node.host.take(), ElementsAre("081#2082130802010100")) << "03h | 11h";
}

TEST(Emergency, WaitsForTheEndOfTheInhibitTime) {
  EmergencyUnderTest node;
  node.emergency.set_inhibit_time(500);  // 50 ms
  EXPECT_THAT(node.fault(0x8611, 0x21, 1s), ElementsAre("081#1186210802010100"));
  EXPECT_THAT(node.reset(1s), IsEmpty());
  EXPECT_EQ(node.emergency.next_due(), DriveTime(1'050ms));
  EXPECT_THAT(node.advance(1'049'999us), IsEmpty());
  EXPECT_THAT(node.advance(1'050ms), ElementsAre("081#0000005002010100"));
  EXPECT_EQ(node.emergency.next_due(), std::nullopt);
  EXPECT_EQ(node.emergency.held_back(), 0U) << "late, not lost";
}

// 1001h in byte 2 of 8210h: 09h (drive) | 11h (communication) = 19h.
TEST(Emergency, SendsThoseThatTheInhibitTimeHeldBackOneByOneInTheirOrder) {
  EmergencyUnderTest node;
  node.emergency.set_inhibit_time(500);
  node.fault(0x8611, 0x21);
  node.reset(10ms);
  node.fault(0x4310, 0x09, 20ms);
  node.emergency.begin_error(0x8210, 30ms);
  EXPECT_THAT(node.advance(50ms), ElementsAre("081#0000005002010100"));
  EXPECT_THAT(node.advance(99ms), IsEmpty());
  EXPECT_THAT(node.advance(100ms), ElementsAre("081#1043090802010200"));
  EXPECT_THAT(node.advance(150ms), ElementsAre("081#1082190802010200"));
  EXPECT_EQ(node.emergency.next_due(), std::nullopt);
  EXPECT_EQ(node.emergency.held_back(), 0U);
}

TEST(Emergency, LeavesOutTheOldestOfMoreThanEightThatWait) {
  EmergencyUnderTest node;
  node.emergency.set_inhibit_time(500);
  node.emergency.begin_error(0x8210, 0ms);
  EXPECT_THAT(node.advance(0ms), SizeIs(1));
  for (std::uint16_t number = 0; number < 10; ++number) {
    node.emergency.begin_error(static_cast<std::uint16_t>(0x8220 + number), 1ms);
  }
  EXPECT_EQ(node.emergency.held_back(), 2U);
  const auto first = node.advance(50ms);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first.front().substr(0, 8), "081#2282") << "8222h: 8220h and 8221h are left out";
}

TEST(Emergency, SendsWhatWasDueBeforeWhatComesLater) {
  EmergencyUnderTest node;
  node.emergency.set_inhibit_time(500);
  node.fault(0x8611, 0x21, 0ms);
  node.reset(10ms);
  EXPECT_THAT(node.fault(0x8611, 0x21, 60ms), ElementsAre("081#0000005002010100"))
      << "due at 50 ms, though advance() was late";
  EXPECT_EQ(node.emergency.next_due(), DriveTime(110ms));
  EXPECT_EQ(node.emergency.held_back(), 0U);
}

TEST(Emergency, IsSentImmediatelyAfterTheInhibitTime) {
  EmergencyUnderTest node;
  node.emergency.set_inhibit_time(500);
  node.fault(0x8611, 0x21, 0ms);
  EXPECT_THAT(node.reset(50ms), ElementsAre("081#0000005002010100"));
}

TEST(Emergency, IsDueAtOnceWhenTheInhibitTimeIsSetTo0) {
  EmergencyUnderTest node;
  node.emergency.set_inhibit_time(60'000);
  node.fault(0x8611, 0x21, 0ms);
  node.reset(10ms);
  node.emergency.set_inhibit_time(0);
  EXPECT_THAT(node.advance(11ms), ElementsAre("081#0000005002010100"));
}

TEST(Emergency, WaitsForAStateThatHasEmergencies) {
  EmergencyUnderTest node;
  node.emergency.set_allowed(false, 0s);
  EXPECT_THAT(node.fault(0x8611, 0x21), IsEmpty());
  EXPECT_EQ(node.emergency.next_due(), std::nullopt);
  EXPECT_THAT(node.advance(1s), IsEmpty());
  node.emergency.set_allowed(true, 2s);
  EXPECT_THAT(node.host.take(), ElementsAre("081#1186210802010100"));
}

TEST(Emergency, IsNotSentWhileBit31Of1014hIs1) {
  EmergencyUnderTest node;
  EXPECT_EQ(node.emergency.set_cob_id(0x8000'0081), AbortCode::none);
  EXPECT_EQ(node.emergency.cob_id(), 0x8000'0081U);
  EXPECT_THAT(node.fault(0x8611, 0x21), IsEmpty());
  EXPECT_EQ(node.emergency.set_cob_id(0x81), AbortCode::none);
  EXPECT_THAT(node.advance(1s), IsEmpty()) << "nothing is sent later";
  EXPECT_THAT(node.reset(1s), ElementsAre("081#0000005002010100"));
}

TEST(Emergency, IsDroppedWhenBit31IsSetWhileItWaits) {
  EmergencyUnderTest node;
  node.emergency.set_inhibit_time(500);
  node.fault(0x8611, 0x21);
  node.reset(10ms);
  node.emergency.set_cob_id(0x8000'0081);
  EXPECT_EQ(node.emergency.next_due(), std::nullopt);
}

TEST(Emergency, HasTheCobIdOfTheNodeByDefault) {
  FakeHost host;
  EXPECT_EQ(Emergency(1, host).cob_id(), 0x81U);
  EXPECT_EQ(Emergency(127, host).cob_id(), 0xFFU);
}

TEST(Emergency, RefusesAnotherCanIdWhileItIsValidWith06090030) {
  EmergencyUnderTest node;
  EXPECT_EQ(node.emergency.set_cob_id(0x82), AbortCode::value_range_exceeded);
  EXPECT_EQ(node.emergency.set_cob_id(0x81), AbortCode::none);
  EXPECT_EQ(node.emergency.cob_id(), 0x81U);
}

TEST(Emergency, TakesAnotherCanIdOverNotValid) {
  EmergencyUnderTest node;
  EXPECT_EQ(node.emergency.set_cob_id(0x8000'0081), AbortCode::none);
  EXPECT_EQ(node.emergency.set_cob_id(0x0000'00A1), AbortCode::none);
  EXPECT_THAT(node.fault(0x8611, 0x21), ElementsAre("0A1#1186210802010100"));
}

TEST(Emergency, RefusesRestrictedCanIdsWith06090030) {
  EmergencyUnderTest node;
  node.emergency.set_cob_id(0x8000'0081);
  for (const std::uint32_t id : {0x000U, 0x001U, 0x07FU, 0x101U, 0x180U, 0x581U, 0x5FFU, 0x601U,
                                 0x67FU, 0x6E0U, 0x6FFU, 0x701U, 0x77FU, 0x780U, 0x7FFU}) {
    EXPECT_EQ(node.emergency.set_cob_id(id), AbortCode::value_range_exceeded) << id;
  }
  for (const std::uint32_t id : {0x080U, 0x100U, 0x181U, 0x580U, 0x600U, 0x680U, 0x6DFU, 0x700U}) {
    EXPECT_EQ(node.emergency.set_cob_id(id), AbortCode::none) << id;
    node.emergency.set_cob_id(0x8000'0081);
  }
}

TEST(Emergency, IsSwitchedOffWithoutACanId) {
  EmergencyUnderTest node;
  EXPECT_EQ(node.emergency.set_cob_id(0x8000'0000), AbortCode::none);
}

TEST(Emergency, RefusesReservedBitsAndExtendedIdsWith06090030) {
  EmergencyUnderTest node;
  for (const std::uint32_t value :
       {0x4000'0081U, 0x2000'0081U, 0x0000'0881U, 0x1000'0081U, 0xC000'0081U, 0xA000'0081U}) {
    EXPECT_EQ(node.emergency.set_cob_id(value), AbortCode::value_range_exceeded) << value;
  }
  EXPECT_EQ(node.emergency.cob_id(), 0x81U);
}

TEST(Emergency, HasItsDefaultsAgainAfterAResetAndSendsAFaultThatLasts) {
  EmergencyUnderTest node;
  node.emergency.set_inhibit_time(500);
  node.fault(0x8611, 0x21);
  node.emergency.set_cob_id(0x8000'0081);
  node.emergency.reset();
  EXPECT_EQ(node.emergency.cob_id(), 0x81U);
  EXPECT_EQ(node.emergency.inhibit_time(), 0);
  EXPECT_THAT(node.update(), IsEmpty()) << "not yet allowed";
  node.emergency.set_allowed(true, 0s);
  EXPECT_THAT(node.host.take(), ElementsAre("081#1186210802010100"));
}

}  // namespace
}  // namespace vdrive::canopen
