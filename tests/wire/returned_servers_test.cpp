// SPDX-License-Identifier: Apache-2.0
#include "guard/returned_servers.hpp"

#include "datagrams.hpp"

#include <gtest/gtest.h>

namespace vdrive::wire {
namespace {

// The prefix of the server with id 0: get_server_client_default_guidPrefix of Fast DDS 2.9.
constexpr GuidPrefix kServer{'D', 'S', 0, 0x5F, 'E', 'P', 'R', 'O', 'S', 'I', 'M', 'A'};
constexpr GuidPrefix kProgram{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};

test::Datagram heartbeat_of(const GuidPrefix& sender, std::uint32_t count,
                            EntityId writer = kParticipantsWriter) {
  return test::DatagramWriter(sender)
      .add(0x07, 1, test::heartbeat(kParticipantsReader, writer, 1, 1, count).bytes())
      .bytes();
}

test::Datagram acknack_of(const GuidPrefix& sender, std::uint32_t count) {
  test::Body body = test::acknack(kParticipantsReader, kParticipantsWriter, 1);
  test::Datagram bytes = body.bytes();
  put_u32(std::span(bytes).last(4), count, true);
  return test::DatagramWriter(sender).add(0x06, 1, bytes).bytes();
}

struct AReturnedServer : testing::Test {
  ReturnedServers servers;
  ReturnedServers::Clock::time_point now{std::chrono::hours{1}};

  AReturnedServer() { servers.found(kServer); }

  bool holds_back(const test::Datagram& datagram) { return servers.holds_back(datagram, now); }

  void wait() { now += ReturnedServers::kMostOvertaken + std::chrono::milliseconds{1}; }
};

TEST_F(AReturnedServer, IsOneWhoseHeartbeatsBeginAgain) {
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 1)));
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 2)));
  wait();
  EXPECT_TRUE(holds_back(heartbeat_of(kServer, 1)));
}

TEST_F(AReturnedServer, IsOneWhoseAcknowledgementsBeginAgain) {
  EXPECT_FALSE(holds_back(acknack_of(kServer, 40)));
  wait();
  EXPECT_TRUE(holds_back(acknack_of(kServer, 1)));
}

TEST_F(AReturnedServer, IsHeldBackUntilTheFormerOneIsRemoved) {
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 40)));
  wait();
  EXPECT_TRUE(holds_back(heartbeat_of(kServer, 2)));
  EXPECT_TRUE(holds_back(heartbeat_of(kServer, 41)));  // all its heartbeats, whatever their counts
  servers.removed(kServer);
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 42)));
}

TEST_F(AReturnedServer, IsHeldBackForALimitedTime) {
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 40)));
  wait();
  EXPECT_TRUE(holds_back(heartbeat_of(kServer, 2)));
  now += ReturnedServers::kLongestWait;
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 3)));
}

TEST_F(AReturnedServer, IsNoneWhoseDatagramsOvertakeEachOther) {
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 40)));
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 1)));
  wait();
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 40)));  // the same server on another interface
}

TEST_F(AReturnedServer, IsNoOtherProgramAndNoOtherWriter) {
  EXPECT_FALSE(holds_back(heartbeat_of(kProgram, 40)));
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 40)));
  wait();
  EXPECT_FALSE(holds_back(heartbeat_of(kProgram, 1)));
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 1, kPublicationsWriter)));
}

TEST_F(AReturnedServer, IsNoneThatTheLibraryDoesNotKnow) {
  servers.removed(kServer);
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 0xFFFF'FFFF)));
  wait();
  EXPECT_FALSE(holds_back(heartbeat_of(kServer, 1)));
}

}  // namespace
}  // namespace vdrive::wire
