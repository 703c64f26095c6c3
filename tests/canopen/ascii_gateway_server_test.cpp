// SPDX-License-Identifier: Apache-2.0
#include "bus/ascii_gateway_server.hpp"

#include "bus/line_reader.hpp"
#include "canopen/recorded_port.hpp"
#include "canopen/tcp_peer.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::canopen {
namespace {

// ---- lines

std::vector<std::string> whole_lines(LineReader& reader) {
  std::vector<std::string> lines;
  while (const auto line = reader.next()) lines.push_back(line->text);
  return lines;
}

TEST(LineReader, CutsAtLineFeedWithAndWithoutCarriageReturn) {
  LineReader reader(100);
  reader.append("one\r\ntwo\n\nthr");
  EXPECT_EQ(whole_lines(reader), (std::vector<std::string>{"one", "two", ""}));
  reader.append("ee\r");
  EXPECT_EQ(whole_lines(reader), std::vector<std::string>{});
  reader.append("\n");
  EXPECT_EQ(whole_lines(reader), std::vector<std::string>{"three"});
}

TEST(LineReader, MarksALineThatIsTooLongAndTakesTheNextOne) {
  LineReader reader(4);
  reader.append("1234\r\n12345\n");
  reader.append(std::string(100'000, 'x'));
  reader.append("\nend\n");
  EXPECT_EQ(reader.next(), (StreamLine{.text = "1234", .is_too_long = false}));
  EXPECT_EQ(reader.next(), (StreamLine{.text = "12345", .is_too_long = true}));
  const auto longest = reader.next();
  ASSERT_TRUE(longest);
  EXPECT_TRUE(longest->is_too_long);
  EXPECT_LE(longest->text.size(), 5U);
  EXPECT_EQ(reader.next(), (StreamLine{.text = "end", .is_too_long = false}));
}

// ---- the server

/// A node that answers each read with the index as u16, and does not answer reads of index 0.
class EchoingNode final : public Port {
 public:
  EchoingNode(asio::io_context& context, Bus& bus, std::uint8_t id)
      : context_(context), bus_(bus), id_(id) {
    bus_.attach(*this);
  }

  ~EchoingNode() override { bus_.detach(*this); }

  EchoingNode(const EchoingNode&) = delete;
  EchoingNode& operator=(const EchoingNode&) = delete;

  void deliver(const Frame& frame) override {
    if (frame.id != 0x600U + id_ || frame.data[0] != 0x40) return;
    if (frame.data[1] == 0 && frame.data[2] == 0) return;
    Frame answer = frame;
    answer.id = 0x580U + id_;
    answer.data[0] = 0x4B;
    answer.data[4] = frame.data[1];
    answer.data[5] = frame.data[2];
    asio::post(context_, [this, answer] {
      bus_.send(answer, this);
    });
  }

 private:
  asio::io_context& context_;
  Bus& bus_;
  std::uint8_t id_;
};

struct GatewayBench {
  explicit GatewayBench(AsciiGatewayServerSettings settings = {}) {
    settings.listen.port = 0;
    server.emplace(context, bus, host, settings);
  }

  std::unique_ptr<TcpPeer> connect() {
    auto peer = std::make_unique<TcpPeer>(context, server->address());
    peer->read();
    return peer;
  }

  /// Runs every handler that is ready.
  void rest() {
    while (context.poll() > 0) {
    }
  }

  /// @return whether the client eventually received exactly `text`.
  bool has_received(const TcpPeer& peer, std::string_view text) {
    const bool has_come = run_until(context, "all lines", [&] {
      return peer.received_bytes() >= text.size() || peer.has_ended();
    });
    EXPECT_EQ(peer.received(), text);
    return has_come && peer.received() == text;
  }

  asio::io_context context;
  Bus bus;
  RecordedHost host;
  RecordedPort port{bus};
  EchoingNode node{context, bus, 3};
  std::optional<AsciiGatewayServer> server;
};

TEST(AsciiGatewayServer, AnswersALineWithALine) {
  GatewayBench bench;
  const auto peer = bench.connect();
  peer->send("[1] 3 r 0x6041 0 u16\r\n");
  // 6041h = 24641
  EXPECT_TRUE(bench.has_received(*peer, "[1] 24641\r\n"));
  EXPECT_EQ(bench.server->counters().commands, 1U);
  EXPECT_EQ(bench.server->counters().clients, 1U);
}

TEST(AsciiGatewayServer, PutsCommandsOnTheBus) {
  GatewayBench bench;
  const auto peer = bench.connect();
  peer->send("[1] 3 start\n");
  EXPECT_TRUE(bench.has_received(*peer, "[1] OK\r\n"));
  EXPECT_EQ(bench.port.frames, Frames{data_frame(0x000, {1, 3})});
}

TEST(AsciiGatewayServer, AnswersManyCommandsInTheirOrder) {
  GatewayBench bench;
  const auto peer = bench.connect();
  // More commands in one block than may wait for one client.
  std::string commands;
  std::string answers;
  for (int i = 1; i <= 500; ++i) {
    const std::string number = std::to_string(i);
    commands += "[" + number + "] 3 r " + number + " 0 u16\n";
    answers += "[" + number + "] " + number + "\r\n";
  }
  peer->send(commands);
  EXPECT_TRUE(bench.has_received(*peer, answers));
}

TEST(AsciiGatewayServer, AnswersAClientThatHasSentAllBeforeItCloses) {
  GatewayBench bench;
  const auto peer = bench.connect();
  peer->send("[1] 3 r 1 0 u16\n[2] 3 r 2 0 u16\n[3] 3 stop\n");
  peer->end_sending();
  ASSERT_TRUE(run_until(bench.context, "the end", [&] {
    return peer->has_ended();
  }));
  EXPECT_EQ(peer->received(), "[1] 1\r\n[2] 2\r\n[3] OK\r\n");
  EXPECT_EQ(bench.server->counters().clients, 0U);
}

TEST(AsciiGatewayServer, TakesNoCommandWhileTheBusIsHeld) {
  GatewayBench bench;
  const RecordedPort slow(bench.bus);
  const auto peer = bench.connect();
  ASSERT_EQ(peer->ask("[1] set node 3\n"), "[1] OK\r\n");
  bench.bus.hold(slow);
  peer->send("[2] 3 start\n[3] 3 stop\n");
  peer->end_sending();
  bench.rest();
  EXPECT_EQ(bench.port.frames, Frames{});
  bench.bus.release(slow);
  ASSERT_TRUE(run_until(bench.context, "the end", [&] {
    return peer->has_ended();
  }));
  EXPECT_EQ(peer->received(), "[1] OK\r\n[2] OK\r\n[3] OK\r\n");
  EXPECT_EQ(bench.port.frames, (Frames{data_frame(0x000, {1, 3}), data_frame(0x000, {2, 3})}));
}

// The frame of a boot-up, which is reported to no client, makes the server run when the bus is
// free, but before the turn that resume() posts. Then the bus is held again.
TEST(AsciiGatewayServer, TakesWhatWaitedWhileTheBusWasHeldBeforeItCloses) {
  GatewayBench bench;
  const RecordedPort slow(bench.bus);
  const auto peer = bench.connect();
  ASSERT_EQ(peer->ask("[1] boot_up_indication Disable\n"), "[1] OK\r\n");
  bench.bus.hold(slow);
  peer->send("[2] 3 start\n");
  peer->end_sending();
  bench.rest();
  // In the first round the server reads the end of the client's data; in the second it could close.
  for (int i = 0; i < 2; ++i) {
    bench.port.send(data_frame(0x703, {0x00}));
    bench.bus.release(slow);
    bench.context.poll_one();
    bench.bus.hold(slow);
    bench.rest();
  }
  bench.bus.release(slow);
  ASSERT_TRUE(run_until(bench.context, "the end", [&] {
    return peer->has_ended();
  }));
  EXPECT_EQ(peer->received(), "[1] OK\r\n[2] OK\r\n");
}

TEST(AsciiGatewayServer, SendsItsRemainingSyncsOnceTheBusIsReleased) {
  GatewayBench bench;
  const RecordedPort slow(bench.bus);
  const auto peer = bench.connect();
  peer->send("[1] _sync 3\n");
  ASSERT_TRUE(run_until(bench.context, "a SYNC", [&] {
    return !bench.port.frames.empty();
  }));
  bench.bus.hold(slow);
  bench.rest();
  EXPECT_EQ(bench.port.frames, Frames(1, data_frame(0x080, {})));
  bench.bus.release(slow);
  EXPECT_TRUE(bench.has_received(*peer, "[1] OK\r\n"));
  EXPECT_EQ(bench.port.frames, Frames(3, data_frame(0x080, {})));
}

TEST(AsciiGatewayServer, EndsAnOverdueTransfer) {
  GatewayBench bench;
  const auto peer = bench.connect();
  peer->send("[1] set sdo_timeout 10\n[2] 3 r 0 0 u16\n");
  EXPECT_TRUE(
      bench.has_received(*peer, "[1] OK\r\n[2] ERROR:0x05040000 #SDO protocol timed out\r\n"));
}

TEST(AsciiGatewayServer, AnswersALineThatIsTooLongWithASyntaxError) {
  GatewayBench bench;
  const auto peer = bench.connect();
  const std::string blanks(AsciiGatewayServer::kLongestLine, ' ');
  peer->send("[7] 3 start" + blanks + "x\n[8] 3 start\n");
  EXPECT_TRUE(bench.has_received(*peer, "[7] ERROR:101 #syntax error\r\n[8] OK\r\n"));
}

TEST(AsciiGatewayServer, AbortsItsTransfersWhenItEnds) {
  GatewayBench bench;
  const auto peer = bench.connect();
  peer->send("[1] 3 r 0 0 u16\n");
  ASSERT_TRUE(run_until(bench.context, "a request", [&] {
    return bench.port.frames.size() == 1;
  }));
  bench.server.reset();
  ASSERT_EQ(bench.port.frames.size(), 2U);
  EXPECT_EQ(bench.port.frames[1], data_frame(0x603, {0x80, 0, 0, 0, 0x20, 0x00, 0x00, 0x08}));
}

TEST(AsciiGatewayServer, ReportsToAllClients) {
  GatewayBench bench;
  const auto first = bench.connect();
  const auto second = bench.connect();
  for (TcpPeer* const peer : {first.get(), second.get()}) {
    ASSERT_EQ(peer->ask("[1] set node 3\n"), "[1] OK\r\n");
  }
  bench.port.send(data_frame(0x703, {0x00}));
  for (TcpPeer* const peer : {first.get(), second.get()}) {
    EXPECT_TRUE(bench.has_received(*peer, "[1] OK\r\n1 3 BOOT_UP\r\n"));
  }
}

TEST(AsciiGatewayServer, LetsTwoClientsReadFromOneNode) {
  GatewayBench bench;
  const auto first = bench.connect();
  const auto second = bench.connect();
  first->send("[1] 3 r 1 0 u16\n[2] 3 r 2 0 u16\n");
  second->send("[1] 3 r 3 0 u16\n[2] 3 r 4 0 u16\n");
  EXPECT_TRUE(bench.has_received(*first, "[1] 1\r\n[2] 2\r\n"));
  EXPECT_TRUE(bench.has_received(*second, "[1] 3\r\n[2] 4\r\n"));
}

TEST(AsciiGatewayServer, RefusesMoreClientsThanItMayHave) {
  GatewayBench bench(AsciiGatewayServerSettings{.most_clients = 1});
  const auto first = bench.connect();
  ASSERT_EQ(first->ask("[1] set node 3\n"), "[1] OK\r\n");
  const auto second = bench.connect();
  ASSERT_TRUE(run_until(bench.context, "the end", [&] {
    return second->has_ended();
  }));
  EXPECT_EQ(second->received(), "ERROR: too many clients\r\n");
  EXPECT_EQ(bench.server->counters().refused_clients, 1U);
  first->close();
  ASSERT_TRUE(run_until(bench.context, "the end of a client", [&] {
    return bench.server->counters().clients == 0;
  }));
  EXPECT_EQ(bench.connect()->ask("[1] set node 3\n"), "[1] OK\r\n");
}

TEST(AsciiGatewayServer, ClosesItsConnectionsWhenItEnds) {
  GatewayBench bench;
  const auto peer = bench.connect();
  ASSERT_EQ(peer->ask("[1] set node 3\n"), "[1] OK\r\n");
  bench.server.reset();
  bench.port.send(data_frame(0x703, {0x00}));  // would reach a dangling port of the server
  ASSERT_TRUE(run_until(bench.context, "the end", [&] {
    return peer->has_ended();
  }));
}

}  // namespace
}  // namespace vdrive::canopen
