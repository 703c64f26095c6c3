// SPDX-License-Identifier: Apache-2.0
// The CiA 309-3 gateway: its PDOs, its SYNC and faults on its bus.
#include "bus/gateway_pdos.hpp"

#include "bus/ascii_gateway.hpp"
#include "bus/ascii_gateway_server.hpp"
#include "canopen/recorded_port.hpp"
#include "canopen/tcp_peer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A gateway with two sessions; answers to the second one are recorded separately.
struct PdoGateway final : GatewayHost {
  void send(const Frame& frame) override { sent.push_back(frame); }

  void answer(GatewaySession session, std::string_view line) override {
    (session == first ? told : others).emplace_back(line);
  }

  void report(GatewaySession session, std::string_view line) override { answer(session, line); }

  std::optional<std::string> disturb(std::uint8_t node, std::string_view fault) override {
    faults.emplace_back(std::to_string(node) + " " + std::string(fault));
    return refusal;
  }

  std::vector<std::string> take(std::string_view line) {
    gateway.take_line(first, line, {});
    return std::exchange(told, {});
  }

  std::vector<std::string> receive(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
    const Frame frame = data_frame(id, data);
    EXPECT_TRUE(gateway.awaits(frame));
    gateway.receive(frame, {});
    return std::exchange(told, {});
  }

  std::vector<std::string> told;
  std::vector<std::string> others;
  Frames sent;
  std::vector<std::string> faults;
  std::optional<std::string> refusal;
  AsciiGateway gateway{{}, *this};
  GatewaySession first = gateway.open();
  GatewaySession second = gateway.open();
};

// 6041h (two bytes) = 0237h, 6064h (four bytes) = 000003E8h.
TEST(GatewayPdo, ThatItReceivesIsReportedAndRead) {
  PdoGateway test;
  EXPECT_THAT(test.take("[1] set rpdo 2 0x381 event 2 0x6041 0 0x6064 0"), ElementsAre("[1] OK"));
  EXPECT_THAT(test.take("[2] r pdo 2"),
              ElementsAre("[2] ERROR:102 #request not processed due to internal state"))
      << "nothing has come";
  EXPECT_THAT(test.receive(0x381, {0x37, 0x02, 0xE8, 0x03, 0x00, 0x00}),
              ElementsAre("1 pdo 2 2 0x237 0x3E8"));
  EXPECT_THAT(test.take("[3] 1 read p 2"), ElementsAre("[3] 1 pdo 2 0x237 0x3E8"));
  EXPECT_THAT(test.others, IsEmpty()) << "of another session";
}

TEST(GatewayPdo, MayHaveDummiesAndTheTypeOfASynchronousOne) {
  PdoGateway test;
  EXPECT_THAT(test.take("[1] set rpdo 1 0x181 sync240 2 5 0 0x6041 0"), ElementsAre("[1] OK"));
  EXPECT_THAT(test.receive(0x181, {0xFF, 0x37, 0x02}), ElementsAre("1 pdo 1 2 0xFF 0x237"));
}

TEST(GatewayPdo, IgnoresFramesThatAreNotItsOwn) {
  PdoGateway test;
  test.take("[1] set rpdo 1 0x181 event 1 0x6041 0");
  EXPECT_FALSE(test.gateway.awaits(data_frame(0x182, {0x37, 0x02})));
  EXPECT_FALSE(test.gateway.awaits(data_frame(0x181, {0x37}))) << "too short";
  EXPECT_FALSE(test.gateway.awaits({.id = 0x181, .is_remote = true, .size = 2}));
  EXPECT_FALSE(test.gateway.awaits({.id = 0x181, .is_extended = true, .size = 2}));
}

TEST(GatewayPdo, IsSentWhenItIsWritten) {
  PdoGateway test;
  EXPECT_THAT(test.take("[1] set tpdo 1 0x401 event 2 0x6040 0 0x607A 0"), ElementsAre("[1] OK"));
  EXPECT_THAT(test.take("[2] w pdo 1 2 0x1F 10000"), ElementsAre("[2] OK"));
  EXPECT_EQ(test.sent, Frames{data_frame(0x401, {0x1F, 0x00, 0x10, 0x27, 0x00, 0x00})});
}

TEST(GatewayPdo, IsReplacedByAnotherOfItsNumberAndGoneWithItsSession) {
  PdoGateway test;
  test.take("[1] set rpdo 1 0x181 event 1 0x6041 0");
  test.take("[2] set rpdo 1 0x182 event 1 0x6041 0");
  EXPECT_FALSE(test.gateway.awaits(data_frame(0x181, {0x37, 0x02})));
  EXPECT_TRUE(test.gateway.awaits(data_frame(0x182, {0x37, 0x02})));
  test.gateway.close(test.first, {});
  EXPECT_FALSE(test.gateway.awaits(data_frame(0x182, {0x37, 0x02})));
}

TEST(GatewayPdo, IsRefusedWithTheReason) {
  const std::vector<std::pair<std::string, std::string>> rows{
      {"set rpdo 0 0x181 event 1 0x6041 0", "ERROR:101"},
      {"set rpdo 513 0x181 event 1 0x6041 0", "ERROR:101"},
      {"set rpdo 1 0x800 event 1 0x6041 0", "ERROR:101"},
      {"set rpdo 1 0x181 often 1 0x6041 0", "ERROR:101"},
      {"set rpdo 1 0x181 sync241 1 0x6041 0", "ERROR:101"},
      {"set rpdo 1 0x181 event 2 0x6041 0", "ERROR:101"},
      {"set rpdo 1 0x181 event 1 0x6041 0 0", "ERROR:101"},
      {"set rpdo 1 0x181 rtr 1 0x6041 0", "ERROR:100"},
      {"set tpdo 1 0x201 sync1 1 0x6040 0", "ERROR:100"},
      {"set tpdox 1 0x201 event 1 0x6040 0", "ERROR:100"},
      {"set rpdo 1 0x181 event 3 0x6064 0 0x606C 0 0x6061 0", "ERROR:401"},
      {"set rpdo 1 0x181 event 1 0x2FFF 0", "ERROR:0x06020000"},
      {"set rpdo 1 0x181 event 1 0x6041 1", "ERROR:0x06090011"},
      {"set rpdo 1 0x181 event 1 0x1008 0", "ERROR:0x06040041"},
      {"set tpdo 1 0x201 event 1 0x1010 1", "ERROR:0x06040041"},
      {"w pdo 2 1 6", "ERROR:102"},
      {"w pdo 1 2 6 1", "ERROR:101"},
      {"w pdo 1 1 0x10000", "ERROR:101"},
      {"r pdo 1", "ERROR:102"},
      {"2 r pdo 1", "ERROR:106"},
      {"1 2 r pdo 1", "ERROR:101"},
      {"r p", "ERROR:101"},
      {"r q 1", "ERROR:100"},
  };
  PdoGateway test;
  test.take("[1] set tpdo 1 0x201 event 1 0x6040 0");
  for (const auto& [command, error] : rows) {
    EXPECT_THAT(test.take("[9] " + command), ElementsAre(HasSubstr("[9] " + error + " #")))
        << command;
  }
  EXPECT_THAT(test.sent, IsEmpty());
}

// ---- SYNC

TEST(GatewaySync, IsSentOneAtATimeAndAnsweredAfterTheLast) {
  PdoGateway test;
  EXPECT_THAT(test.take("[1] _sync 2"), IsEmpty());
  EXPECT_THAT(test.take("[2] set node 3"), IsEmpty()) << "it waits for the SYNCs";
  EXPECT_EQ(test.gateway.waiting(test.first), 2U);
  test.gateway.send_sync({});
  EXPECT_EQ(test.sent, Frames{data_frame(0x080, {})});
  EXPECT_THAT(test.told, IsEmpty());
  test.gateway.send_sync({});
  EXPECT_THAT(test.told, ElementsAre("[1] OK", "[2] OK"));
  EXPECT_FALSE(test.gateway.has_syncs());
  test.gateway.send_sync({});
  EXPECT_EQ(test.sent.size(), 2U);
}

TEST(GatewaySync, IsOneWithoutANumberAndNoneOfASessionThatHasClosed) {
  PdoGateway test;
  test.take("[1] 1 _SYNC");
  test.gateway.send_sync({});
  EXPECT_THAT(test.told, ElementsAre("[1] OK"));
  test.take("[2] _sync 5");
  test.gateway.close(test.first, {});
  EXPECT_FALSE(test.gateway.has_syncs());
}

TEST(GatewaySync, IsRefusedForNoneOrTooMany) {
  PdoGateway test;
  for (const std::string count : {"0", "100001", "-1", "x"}) {
    EXPECT_THAT(test.take("[1] _sync " + count), ElementsAre("[1] ERROR:101 #syntax error"))
        << count;
  }
}

// ---- faults of the bus

TEST(GatewayDisturb, PassesOnTheNodeAndTheFault) {
  PdoGateway test;
  EXPECT_THAT(test.take("[1] 3 _disturb lost 5% # often"), ElementsAre("[1] OK"));
  EXPECT_THAT(test.take("[2] 1 0 _disturb none"), ElementsAre("[2] OK"));
  EXPECT_THAT(test.take("[3] _disturb lost"), ElementsAre(HasSubstr("[3] ERROR:105")));
  EXPECT_THAT(test.take("[4] 128 _disturb lost"), ElementsAre(HasSubstr("[4] ERROR:107")));
  EXPECT_THAT(test.take("[5] 0 _DISTURB Late 4ms"), ElementsAre("[5] OK"));
  EXPECT_THAT(test.take("[6] 2 _disturb NONE"), ElementsAre("[6] OK"));
  EXPECT_THAT(test.faults, ElementsAre("3 lost 5%", "0 none", "0 late 4ms", "2 none"));
  test.refusal = "no such fault";
  EXPECT_THAT(test.take("[7] 3 _disturb x"),
              ElementsAre("[7] ERROR:101 #syntax error: no such fault"));
}

// ---- the server

struct ServedGateway {
  asio::io_context context;
  Bus bus;
  RecordedHost host;
  RecordedPort port{bus};
  AsciiGatewayServer server{context, bus, host, {.listen = {.port = 0}}};
  TcpPeer peer{context, server.address()};

  std::string ask(const std::string& line) {
    peer.read();
    return peer.ask(line + "\n");
  }
};

TEST(GatewayServer, SendsTheSyncsOfACommandAndThenAnswers) {
  ServedGateway test;
  EXPECT_EQ(test.ask("[1] _sync 100"), "[1] OK\r\n");
  EXPECT_EQ(test.port.frames, Frames(100, data_frame(0x080, {})));
}

TEST(GatewayServer, LetsItsHostDisturbTheBus) {
  ServedGateway test;
  EXPECT_EQ(test.ask("[1] 3 _disturb lost"), "[1] OK\r\n");
  EXPECT_EQ(test.peer.ask("[2] 4 _disturb lost\n"), "[2] ERROR:101 #syntax error: no node 4\r\n");
}

}  // namespace
}  // namespace vdrive::canopen
