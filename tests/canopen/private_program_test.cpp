// SPDX-License-Identifier: Apache-2.0
// The program vdrive-canopen alone: it answers, and it serves a private bench. Its clients speak
// socketcand. program_test has it with services over DDS.
#include "canopen/running_canopen.hpp"
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace vdrive::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(PrivateCanopenProgram, FailsWhenItsAnswerCouldNotBeWritten) {
  for (const std::string flag : {"--help", "--version", "--check"}) {
    const Finished full =
        Process("/bin/sh", {"-c", VDRIVE_CANOPEN " " + flag + " > /dev/full"}).wait();
    EXPECT_EQ(full.code, 1) << flag;
    EXPECT_THAT(full.errors, HasSubstr("standard output could not be written: No space left"));
  }
}

TEST(PrivateCanopenProgram, ServesAPrivateBenchAndCountsAtItsEnd) {
  RunningCanopen program("--private --axes 3 --gateway 127.0.0.1:0");
  EXPECT_THAT(program.first_line(), HasSubstr("bus 1: 3 nodes (1 to 3), socketcand 127.0.0.1:"));
  EXPECT_THAT(program.first_line(), HasSubstr(", gateway 127.0.0.1:"));
  EXPECT_THAT(program.first_line(), HasSubstr(", session 0x"));
  {
    SocketcandPeer peer(program.port());
    EXPECT_EQ(peer.upload(3, "0 10 0"), "4300100092010200") << "1000h = 0002 0192h";
  }
  const Finished ended = program.stop();
  EXPECT_EQ(ended.code, 0) << ended.errors;
  EXPECT_THAT(ended.output, HasSubstr("vdrive-canopen: bus 1: "));
  EXPECT_THAT(ended.output, HasSubstr(" frames, 0 dropped PDOs"));
}

TEST(PrivateCanopenProgram, StepsAPrivateBenchBySync) {
  const RunningCanopen program("--private --axes 1 --sync-steps 1ms");
  SocketcandPeer peer(program.port());
  peer.send_text("< send 601 8 2b 17 10 0 3 0 0 0 >");  // a heartbeat each 3 ms
  EXPECT_EQ(peer.next_data("581"), "6017100000000000");
  EXPECT_EQ(peer.next_data("701"), "7F") << "the first one at once";
  peer.send_text("< send 80 0 >< send 80 0 >< send 80 0 >< send 601 8 40 41 60 0 0 0 0 0 >");
  EXPECT_EQ(peer.next_data("701"), "7F") << "behind the third SYNC";
  EXPECT_THAT(peer.next_data("581"), StartsWith("4B416000"));
}

// CiA 301, 7.2.4.3.9: 1008h, "vdrive", by blocks. The block has one segment, of whose 7 bytes one
// is unused: n = 1 in bits 2 to 4 of C1h.
TEST(PrivateCanopenProgram, SendsATextByBlocks) {
  const RunningCanopen program("--private --axes 1");
  SocketcandPeer peer(program.port());
  peer.send_text("< send 601 8 a4 8 10 0 7f 0 0 0 >");
  EXPECT_EQ(peer.next_data("581"), "C608100006000000");
  peer.send_text("< send 601 8 a3 0 0 0 0 0 0 0 >");
  EXPECT_EQ(peer.next_data("581"), "8176647269766500");
  peer.send_text("< send 601 8 a2 1 7f 0 0 0 0 0 >");
  EXPECT_THAT(peer.next_data("581"), StartsWith("C5"));
  peer.send_text("< send 601 8 a1 0 0 0 0 0 0 0 >");
}

}  // namespace
}  // namespace vdrive::test
