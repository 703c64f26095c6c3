// SPDX-License-Identifier: Apache-2.0
// The program vdrive-canopen on its own, with a private bench; its clients speak socketcand.
// program_test runs it with services over DDS.
#include "canopen/running_canopen.hpp"
#include "support/process_tree.hpp"
#include "support/temporary_directory.hpp"
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

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
  peer.send_text("< send 601 8 2b 17 10 0 3 0 0 0 >");  // a heartbeat every 3 ms
  EXPECT_EQ(peer.next_data("581"), "6017100000000000");
  EXPECT_EQ(peer.next_data("701"), "7F") << "the first one at once";
  peer.send_text("< send 80 0 >< send 80 0 >< send 80 0 >< send 601 8 40 41 60 0 0 0 0 0 >");
  EXPECT_EQ(peer.next_data("701"), "7F") << "behind the third SYNC";
  EXPECT_THAT(peer.next_data("581"), StartsWith("4B416000"));
}

/// A client of the CiA 309-3 gateway.
class GatewayPeer {
 public:
  explicit GatewayPeer(int port) : connection_(connected(port)) {
    const timeval patience{.tv_sec = kProgramPatience.count(), .tv_usec = 0};
    (void)setsockopt(connection_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }

  ~GatewayPeer() { close(connection_); }

  GatewayPeer(const GatewayPeer&) = delete;
  GatewayPeer& operator=(const GatewayPeer&) = delete;

  /// @return the answer to a command, without its sequence number.
  std::string ask(const std::string& command) {
    const std::string number = "[" + std::to_string(++last_) + "] ";
    const std::string line = number + command + "\n";
    (void)send(connection_, line.data(), line.size(), MSG_NOSIGNAL);
    while (true) {
      const std::size_t begin = received_.find(number);
      const std::size_t end = received_.find("\r\n", begin == std::string::npos ? 0 : begin);
      if (begin != std::string::npos && end != std::string::npos) {
        return received_.substr(begin + number.size(), end - begin - number.size());
      }
      std::array<char, 4096> part{};
      const ssize_t got = recv(connection_, part.data(), part.size(), 0);
      if (got <= 0) throw std::runtime_error("no answer to '" + command + "': " + received_);
      received_.append(part.data(), static_cast<std::size_t>(got));
    }
  }

 private:
  int connection_;
  int last_ = 0;
  std::string received_;
};

/// A script enables the axis over a bus that loses and delays frames, using only the SYNC and PDOs
/// of the gateway.
/// @return the log of the bus
std::string log_of_a_disturbed_run(const std::filesystem::path& file) {
  RunningCanopen program(std::vector<std::string>{
      "--private", "--axes", "2", "--sync-steps", "1ms", "--gateway", "127.0.0.1:0", "--log",
      file.string(), "--disturb", "2 lost 30% sent seed 4", "--disturb", "2 late 3ms 30% sent"});
  GatewayPeer peer(program.gateway_port());
  EXPECT_EQ(peer.ask("set rpdo 1 0x181 event 1 0x6041 0"), "OK");
  EXPECT_EQ(peer.ask("set tpdo 1 0x201 event 1 0x6040 0"), "OK");
  EXPECT_EQ(peer.ask("0 start"), "OK");
  EXPECT_EQ(peer.ask("1 1 w 0x1800 2 u8 1"), "OK");
  for (const std::string word : {"0x06", "0x07", "0x0F"}) {
    EXPECT_EQ(peer.ask("w pdo 1 1 " + word), "OK");
    EXPECT_EQ(peer.ask("_sync 2"), "OK");
  }
  EXPECT_EQ(peer.ask("_sync 100"), "OK");
  const std::string status = peer.ask("r pdo 1");
  EXPECT_THAT(status, StartsWith("1 pdo 1 0x"));
  EXPECT_EQ(std::stoul(status.substr(8), nullptr, 16) & 0x6FU, 0x27U) << "Operation enabled";
  EXPECT_EQ(peer.ask("1 _disturb bus_off for 5ms"), "OK");
  EXPECT_EQ(peer.ask("_sync 10"), "OK");
  const Finished ended = program.stop();
  EXPECT_EQ(ended.code, 0) << ended.errors;
  EXPECT_THAT(ended.output, testing::Not(HasSubstr(" 0 frames disturbed")));
  return text_of(file);
}

// After bus-off node 1 sends 8140h, and 8130h as the reaction of its enabled drive. The last of the
// 100 SYNCs follows the six of the enabling words and 99 others, so it is sent at 105 ms of drive
// time.
TEST(PrivateCanopenProgram, LogsTheSameFramesInEachDisturbedRun) {
  const TemporaryDirectory directory;
  const std::string log = log_of_a_disturbed_run(directory.path() / "first.log");
  EXPECT_THAT(log, StartsWith("(0000000000.000000) can0 "));
  EXPECT_THAT(log, HasSubstr("(0000000000.105000) can0 080#\n"));
  EXPECT_THAT(log, HasSubstr(" can0 081#4081"));
  EXPECT_EQ(log_of_a_disturbed_run(directory.path() / "second.log"), log);
}

TEST(PrivateCanopenProgram, RefusesAFaultThatItCannotMake) {
  const RunningCanopen program("--private --axes 2 --gateway 127.0.0.1:0");
  GatewayPeer peer(program.gateway_port());
  EXPECT_THAT(peer.ask("9 _disturb lost"),
              HasSubstr("bus 1 has no node 9; it has 2 nodes (1 to 2)"));
  EXPECT_THAT(peer.ask("1 _disturb gone"),
              HasSubstr("'gone' is not a fault of the bus; write lost"));
  EXPECT_EQ(peer.ask("1 _disturb lost 5%"), "OK");
  EXPECT_EQ(peer.ask("1 _disturb none"), "OK");
  EXPECT_EQ(peer.ask("0 _disturb none"), "OK");
  const Finished refused =
      Process(VDRIVE_CANOPEN, {"--private", "--axes", "2", "--disturb", "3 lost", "--check"})
          .wait();
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("a fault names node 3, but the bus has 2 nodes (1 to 2)"));
}

// No frame of node 1 gets through, neither with a fault from the start nor with one by a command,
// so reading its 1017h times out.
TEST(PrivateCanopenProgram, DisturbsABusInRealTime) {
  const RunningCanopen program(std::vector<std::string>{
      "--private", "--axes", "2", "--gateway", "127.0.0.1:0", "--disturb", "1 lost for 1000s"});
  GatewayPeer peer(program.gateway_port());
  for (const std::string end : {"1 _disturb none", "0 _disturb none"}) {
    EXPECT_EQ(peer.ask("set sdo_timeout 50"), "OK");
    EXPECT_THAT(peer.ask("1 r 0x1017 0 u16"), StartsWith("ERROR:0x05040000")) << end;
    EXPECT_EQ(peer.ask(end), "OK");
    EXPECT_EQ(peer.ask("set sdo_timeout 40000"), "OK");
    EXPECT_EQ(peer.ask("1 r 0x1017 0 u16"), "0") << end;
    EXPECT_EQ(peer.ask("0 _disturb lost for 1000s"), "OK");
  }
}

TEST(PrivateCanopenProgram, FailsAtItsEndWhenItsLogIsNotWhole) {
  RunningCanopen program("--private --axes 1 --log /dev/full");
  const Finished ended = program.stop();
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.errors, HasSubstr("log '/dev/full' cannot be written: No space left"));
}

// CiA 301, 7.2.4.3.9: block upload of 1008h, "vdrive". The block has one segment with one unused
// byte of 7: n = 1 in bits 2 to 4 of C1h.
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
