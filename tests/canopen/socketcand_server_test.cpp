// SPDX-License-Identifier: Apache-2.0
#include "bus/socketcand_server.hpp"

#include "canopen/recorded_port.hpp"
#include "canopen/tcp_peer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

/// A server on the loopback interface, on any free TCP port, and a port of the test on the same
/// bus.
struct SocketcandBench {
  explicit SocketcandBench(SocketcandSettings settings = {}) {
    settings.listen.port = 0;
    host.time = std::chrono::microseconds(1'500'000);
    server.emplace(context, bus, host, settings);
  }

  /// @return a client that has received the greeting.
  std::unique_ptr<TcpPeer> connect() {
    auto peer = std::make_unique<TcpPeer>(context, server->address());
    peer->read();
    EXPECT_EQ(peer->next_block(0), "< hi >");
    return peer;
  }

  /// @return a client in raw mode whose first frames are already on their way.
  std::unique_ptr<TcpPeer> connect_raw() {
    auto peer = connect();
    EXPECT_EQ(peer->ask("< open can0 >"), "< ok >");
    EXPECT_EQ(peer->ask("< rawmode >"), "< ok >");
    EXPECT_EQ(peer->ask("< echo >"), "< echo >");
    return peer;
  }

  bool wait_for(std::string_view what, const std::function<bool()>& condition) {
    return run_until(context, what, condition);
  }

  asio::io_context context;
  Bus bus;
  RecordedHost host;
  RecordedPort port{bus};
  std::optional<SocketcandServer> server;
};

TEST(SocketcandServer, ListensOnLoopbackAtAFreePort) {
  SocketcandBench bench;
  EXPECT_EQ(bench.server->address().host, "127.0.0.1");
  EXPECT_NE(bench.server->address().port, 0);
}

TEST(SocketcandServer, NamesTheAddressThatIsInUse) {
  SocketcandBench bench;
  const TcpAddress taken = bench.server->address();
  try {
    const SocketcandServer second(bench.context, bench.bus, bench.host, {.listen = taken});
    FAIL() << "two servers listen at one port";
  } catch (const std::runtime_error& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find(address_text(taken)), std::string::npos) << message;
  }
}

TEST(SocketcandServer, RefusesAHostThatIsNoAddress) {
  SocketcandBench bench;
  EXPECT_THROW(SocketcandServer(bench.context, bench.bus, bench.host,
                                {.listen = {.host = "no.such.host", .port = 0}}),
               std::runtime_error);
}

TEST(SocketcandServer, AnswersEachWordOfTheHandshakeInASeparateBlock) {
  // python-can compares each received block with the expected answer.
  SocketcandBench bench;
  const auto peer = bench.connect();
  EXPECT_EQ(peer->ask("< open can0 >"), "< ok >");
  EXPECT_EQ(peer->ask("< rawmode >"), "< ok >");
  EXPECT_EQ(bench.server->counters().clients, 1U);
  EXPECT_EQ(bench.server->counters().connections, 1U);
}

TEST(SocketcandServer, PutsFramesOfAClientOnTheBus) {
  SocketcandBench bench;
  const auto peer = bench.connect_raw();
  peer->send("< send 601 8 40 41 60 0 0 0 0 0 >");
  ASSERT_TRUE(bench.wait_for("a frame", [&] {
    return !bench.port.frames.empty();
  }));
  EXPECT_EQ(bench.port.frames, Frames{data_frame(0x601, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0})});
  EXPECT_EQ(bench.server->counters().received_frames, 1U);
}

TEST(SocketcandServer, SendsFramesOfTheBusWithTheirTime) {
  SocketcandBench bench;
  const auto peer = bench.connect_raw();
  const std::size_t before = peer->blocks();
  bench.port.send(data_frame(0x581, {0x4B, 0x41, 0x60, 0x00, 0x50, 0x02, 0, 0}));
  EXPECT_EQ(peer->next_block(before), "\n< frame 581 1.500000 4B41600050020000 >");
  ASSERT_TRUE(bench.wait_for("a count", [&] {
    return bench.server->counters().sent_frames == 1;
  }));
}

TEST(SocketcandServer, ShowsAClientTheFramesOfOthersAndNotItsOwn) {
  SocketcandBench bench;
  const auto sender = bench.connect_raw();
  const auto other = bench.connect_raw();
  const std::size_t of_sender = sender->blocks();
  const std::size_t of_other = other->blocks();
  sender->send("< send 080 0  >");
  EXPECT_EQ(other->next_block(of_other), "\n< frame 080 1.500000  >");
  EXPECT_EQ(sender->ask("< echo >"), "< echo >");
  EXPECT_EQ(sender->blocks(), of_sender + 1) << "the echo only";
}

TEST(SocketcandServer, SendsNoFramesBeforeRawMode) {
  SocketcandBench bench;
  const auto peer = bench.connect();
  EXPECT_EQ(peer->ask("< open can0 >"), "< ok >");
  bench.port.send(data_frame(0x181, {1}));
  EXPECT_EQ(peer->ask("< echo >"), "< echo >");
  EXPECT_EQ(peer->received(), "< hi >< ok >< echo >");
}

TEST(SocketcandServer, KeepsTheAnswerToRawmodeApartFromTheFirstFrames) {
  SocketcandBench bench;
  const auto peer = bench.connect();
  EXPECT_EQ(peer->ask("< open can0 >"), "< ok >");
  const std::size_t before = peer->blocks();
  peer->send("< rawmode >");
  // A busy bus: frames arrive in every turn of the server's loop.
  ASSERT_TRUE(bench.wait_for("the answer", [&] {
    bench.port.send(data_frame(0x181, {1}));
    return peer->blocks() > before;
  }));
  EXPECT_EQ(peer->next_block(before), "< ok >");
  // The client has read the answer; now the waiting frames follow.
  peer->send("< send 000 2 1 0 >");
  ASSERT_TRUE(bench.wait_for("frames", [&] {
    return peer->blocks() > before + 1;
  }));
  EXPECT_TRUE(peer->next_block(before + 1).starts_with("\n< frame 181 "));
}

TEST(SocketcandServer, SendsTheFirstFramesToAClientThatOnlyListens) {
  SocketcandBench bench;
  const auto peer = bench.connect();
  EXPECT_EQ(peer->ask("< open can0 >"), "< ok >");
  EXPECT_EQ(peer->ask("< rawmode >"), "< ok >");
  const std::size_t before = peer->blocks();
  bench.port.send(data_frame(0x701, {0}));
  EXPECT_EQ(peer->next_block(before), "\n< frame 701 1.500000 00 >");
}

TEST(SocketcandServer, AnswersFramesThatCameTogetherWithRawmode) {
  SocketcandBench bench;
  const auto peer = bench.connect();
  const auto other = bench.connect_raw();
  other->send("< send 701 1 5 >");  // shows that the bus still works
  ASSERT_TRUE(bench.wait_for("a frame", [&] {
    return bench.port.frames.size() == 1;
  }));
  peer->send("< open can0 >< rawmode >< send 080 0 >");
  ASSERT_TRUE(bench.wait_for("a frame", [&] {
    return bench.port.frames.size() == 2;
  }));
  bench.port.send(data_frame(0x181, {7}));
  ASSERT_TRUE(bench.wait_for("all answers", [&] {
    return peer->received() == "< hi >< ok >< ok >\n< frame 181 1.500000 07 >";
  }));
}

TEST(SocketcandServer, AnswersAMalformedWordAndContinues) {
  SocketcandBench bench;
  const auto peer = bench.connect_raw();
  EXPECT_EQ(peer->ask("< send 123 9 1 2 3 4 5 6 7 8 9 >"), "< error frame has more than 8 bytes >");
  EXPECT_EQ(bench.server->counters().refused_words, 1U);
  peer->send("< send 123 0 >");
  ASSERT_TRUE(bench.wait_for("a frame", [&] {
    return !bench.port.frames.empty();
  }));
}

TEST(SocketcandServer, ClosesAConnectionWhoseBusHasNoName) {
  SocketcandBench bench;
  const auto peer = bench.connect();
  EXPECT_EQ(peer->ask("< open >"), "< error could not open bus >");
  ASSERT_TRUE(bench.wait_for("the end", [&] {
    return peer->has_ended();
  }));
  EXPECT_EQ(bench.server->counters().clients, 0U);
}

TEST(SocketcandServer, AnswersAClientThatHasSentAll) {
  SocketcandBench bench;
  const auto peer = bench.connect();
  peer->send("< open can0 >< rawmode >< send 123 0 >< echo >");
  peer->end_sending();
  ASSERT_TRUE(bench.wait_for("the end", [&] {
    return peer->has_ended();
  }));
  EXPECT_EQ(peer->received(), "< hi >< ok >< ok >< echo >");
  EXPECT_EQ(bench.port.frames, Frames{data_frame(0x123, {})});
}

TEST(SocketcandServer, TakesAClientThatGoesForAnUnpluggedCable) {
  SocketcandBench bench;
  const auto leaving = bench.connect_raw();
  const auto staying = bench.connect_raw();
  leaving->close();
  ASSERT_TRUE(bench.wait_for("the end of a client", [&] {
    return bench.server->counters().clients == 1;
  }));
  const std::size_t before = staying->blocks();
  bench.port.send(data_frame(0x181, {1}));
  EXPECT_EQ(staying->next_block(before), "\n< frame 181 1.500000 01 >");
}

TEST(SocketcandServer, RefusesMoreClientsThanItMayHave) {
  SocketcandBench bench(SocketcandSettings{.most_clients = 1});
  const auto first = bench.connect();
  TcpPeer second(bench.context, bench.server->address());
  second.read();
  EXPECT_EQ(second.next_block(0), "< error too many clients >");
  ASSERT_TRUE(bench.wait_for("the end", [&] {
    return second.has_ended();
  }));
  EXPECT_EQ(bench.server->counters().refused_clients, 1U);
  EXPECT_EQ(first->ask("< echo >"), "< echo >");
}

TEST(SocketcandServer, HasRoomAgainAfterAClientHasGone) {
  SocketcandBench bench(SocketcandSettings{.most_clients = 1});
  bench.connect()->close();
  ASSERT_TRUE(bench.wait_for("the end of a client", [&] {
    return bench.server->counters().clients == 0;
  }));
  EXPECT_EQ(bench.connect()->ask("< open can0 >"), "< ok >");
}

TEST(SocketcandServer, DropsTheOldestFramesOfAClientThatDoesNotRead) {
  constexpr std::size_t kMostWaiting = 64;
  SocketcandBench bench(SocketcandSettings{.most_waiting_frames = kMostWaiting});
  const auto reader = bench.connect_raw();
  TcpPeer sleeper(bench.context, bench.server->address());  // never reads
  sleeper.send("< open can0 >< rawmode >");
  // Once the error for this word is counted, the session is in raw mode.
  sleeper.send("< nonsense >");
  ASSERT_TRUE(bench.wait_for("a refused word", [&] {
    return bench.server->counters().refused_words == 1;
  }));
  const std::size_t head = reader->received_bytes();
  const std::size_t frame = std::string("\n< frame 181 1.500000 0102030405060708 >").size();
  // The kernel buffers some 100 kB for the sleeper; those frames are not dropped.
  constexpr std::uint64_t kFarMore = 1'000'000;
  std::uint64_t sent = 0;
  while (bench.server->counters().dropped_frames < 10 && sent < kFarMore) {
    for (std::size_t i = 0; i < kMostWaiting / 2; ++i, ++sent) {
      bench.port.send(data_frame(0x181, {1, 2, 3, 4, 5, 6, 7, 8}));
    }
    ASSERT_TRUE(bench.wait_for("the reader to have all", [&] {
      return reader->received_bytes() >= head + sent * frame;
    }));
  }
  EXPECT_GE(bench.server->counters().dropped_frames, 10U);
  EXPECT_EQ(reader->received_bytes(), head + sent * frame);
  EXPECT_EQ(reader->ask("< echo >"), "< echo >");
}

/// A client that holds the bus: it never reads, so its kernel buffer and the server's queue fill
/// up.
struct HeldBus {
  static constexpr std::size_t kMostWaiting = 64;

  HeldBus() {
    sleeper.send("< open can0 >< rawmode >");
    // After the second one the client is certainly in raw mode and receives its frames immediately.
    for (std::uint64_t refused = 1; refused <= 2; ++refused) {
      sleeper.send("< nonsense >");
      EXPECT_TRUE(bench.wait_for("a refused word", [&] {
        return bench.server->counters().refused_words == refused;
      }));
    }
    while (!bench.bus.is_held() && sent < 1'000'000) {
      bench.port.send(data_frame(0x181, {1, 2, 3, 4, 5, 6, 7, 8}));
      ++sent;
      bench.context.poll();
    }
    EXPECT_TRUE(bench.bus.is_held());
  }

  SocketcandBench bench{SocketcandSettings{.most_waiting_frames = kMostWaiting, .holds_bus = true}};
  std::unique_ptr<TcpPeer> other = bench.connect();
  TcpPeer sleeper{bench.context, bench.server->address()};
  std::size_t sent = 0;
};

TEST(SocketcandServer, ReadsFromNobodyWhileAClientThatDoesNotReadHoldsTheBus) {
  HeldBus held;
  held.other->send("< open can0 >< bcmmode >< send 80 0 >< send 81 0 >");
  ASSERT_TRUE(held.bench.wait_for("a report", [&] {
    return !held.bench.host.reports.empty();
  }));
  EXPECT_THAT(held.bench.host.reports.front(),
              testing::HasSubstr("a client is not reading: 65 frames are queued"));
  EXPECT_TRUE(held.bench.port.frames.empty());
  held.sleeper.read();
  ASSERT_TRUE(held.bench.wait_for("the frames of the other client", [&] {
    return held.bench.port.frames.size() == 2;
  }));
  ASSERT_TRUE(held.bench.wait_for("all frames",
                                  [&] {
                                    return held.sleeper.received_frames() == held.sent + 2;
                                  }))
      << held.sleeper.received_frames() << " of " << held.sent + 2;
  EXPECT_EQ(held.bench.server->counters().dropped_frames, 0U);
}

TEST(SocketcandServer, DoesNotLetAClientHoldTheBusThatHasGone) {
  HeldBus held;
  held.other->send("< open can0 >< bcmmode >< send 80 0 >");
  held.sleeper.close();
  EXPECT_TRUE(held.bench.wait_for("the frame of the other client", [&] {
    return held.bench.port.frames.size() == 1;
  }));
  EXPECT_FALSE(held.bench.bus.is_held());
}

TEST(SocketcandServer, HoldsTheBusBetweenTwoWordsThatCameTogether) {
  SocketcandBench bench(SocketcandSettings{.most_waiting_frames = 2, .holds_bus = true});
  const auto reader = bench.connect_raw();
  const auto sender = bench.connect_raw();
  std::string words;
  for (int i = 0; i < 100; ++i) words += "< send 80 0 >";
  std::size_t most_in_a_turn = 0;
  sender->send(words);
  std::size_t before = 0;
  ASSERT_TRUE(bench.wait_for("all frames", [&] {
    most_in_a_turn = std::max(most_in_a_turn, bench.port.frames.size() - before);
    before = bench.port.frames.size();
    return reader->received_frames() == 100;
  }));
  EXPECT_EQ(most_in_a_turn, 3U) << "the third one finds two that wait";
}

TEST(SocketcandServer, SendsWhatWaitsToAClientThatHasSentAll) {
  SocketcandBench bench;
  const auto peer = bench.connect_raw();
  bench.port.send(data_frame(0x181, {1}));
  peer->end_sending();
  ASSERT_TRUE(bench.wait_for("the end", [&] {
    return peer->has_ended();
  }));
  EXPECT_EQ(peer->received_frames(), 1U);
}

TEST(SocketcandServer, TakesAFloodOfFramesInTheirOrder) {
  SocketcandBench bench;
  const auto flooding = bench.connect_raw();
  const auto other = bench.connect_raw();
  // 2,000 frames, 30 kB, are several blocks for the server. It serves the other client in between.
  constexpr std::uint32_t kFrames = 2'000;
  std::string flood;
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    flood += "< send 123 2 " + std::to_string(i / 100) + " " + std::to_string(i % 100) + " >";
  }
  flooding->send(flood);
  other->send("< send 0 2 2 0 >");
  ASSERT_TRUE(bench.wait_for("all frames", [&] {
    return bench.port.frames.size() == kFrames + 1;
  }));
  std::uint32_t next = 0;
  std::size_t place_of_other = 0;
  for (std::size_t i = 0; i < bench.port.frames.size(); ++i) {
    const Frame& frame = bench.port.frames[i];
    if (frame.id == 0) {
      place_of_other = i;
      continue;
    }
    // Reads decimal digits as hexadecimal: 10 becomes 16.
    const auto from_decimal = [](std::uint32_t number) {
      return number / 10 * 16 + number % 10;
    };
    ASSERT_EQ(frame.data[0], from_decimal(next / 100));
    ASSERT_EQ(frame.data[1], from_decimal(next % 100));
    ++next;
  }
  EXPECT_LT(place_of_other, kFrames / 2) << "a flood does not keep others out";
}

TEST(SocketcandServer, ReadsNoFurtherFromAClientThatDoesNotReadItsAnswers) {
  SocketcandBench bench;
  TcpPeer flooding(bench.context, bench.server->address());
  const auto other = bench.connect();
  // Several sends, since one send of all would block until the server reads.
  std::string echoes;
  for (int i = 0; i < 1'000; ++i) echoes += "< echo >";
  for (int i = 0; i < 5; ++i) flooding.send(echoes);
  EXPECT_EQ(other->ask("< echo >"), "< echo >");
  // The flooding client is served again once it reads.
  flooding.read();
  const std::size_t whole = std::string("< hi >").size() + 5'000 * std::string("< echo >").size();
  ASSERT_TRUE(bench.wait_for("all echoes", [&] {
    return flooding.received().size() >= whole;
  }));
}

TEST(SocketcandServer, SendsStatisticsInControlMode) {
  SocketcandBench bench;
  const auto peer = bench.connect_raw();
  peer->send("< send 123 3 1 2 3 >");
  ASSERT_TRUE(bench.wait_for("a frame", [&] {
    return !bench.port.frames.empty();
  }));
  bench.port.send(data_frame(0x181, {1, 2}));
  bench.port.send(data_frame(0x182, {}));
  ASSERT_TRUE(bench.wait_for("frames", [&] {
    return peer->received().ends_with("< frame 182 1.500000  >");
  }));
  const std::size_t before = peer->blocks();
  EXPECT_EQ(peer->ask("< controlmode >"), "< ok >");
  peer->send("< statistics 10 >");
  EXPECT_EQ(peer->next_block(before + 1), "< stat 2 2 3 1 >");
}

TEST(SocketcandServer, ClosesItsConnectionsWhenItEnds) {
  SocketcandBench bench;
  const auto peer = bench.connect_raw();
  bench.server.reset();
  bench.port.send(data_frame(0x181, {1}));  // would reach a dangling port of the server
  ASSERT_TRUE(run_until(bench.context, "the end", [&] {
    return peer->has_ended();
  }));
}

// ---- addresses

TEST(TcpAddress, ReadsHostAndPort) {
  EXPECT_EQ(parse_tcp_address("127.0.0.1:29536"), (TcpAddress{"127.0.0.1", 29536}));
  EXPECT_EQ(parse_tcp_address("0.0.0.0:0"), (TcpAddress{"0.0.0.0", 0}));
  EXPECT_EQ(parse_tcp_address("localhost:1"), (TcpAddress{"127.0.0.1", 1}));
  EXPECT_EQ(parse_tcp_address("[::1]:65535"), (TcpAddress{"::1", 65535}));
}

TEST(TcpAddress, RefusesWhatIsNoHostAndPort) {
  for (const char* const text :
       {"", ":", "127.0.0.1", "127.0.0.1:", ":29536", "127.0.0.1:65536", "127.0.0.1:-1",
        "127.0.0.1:x", "::1:29536", "[]:1", "[::1:1", "[127.0.0.1]:1"}) {
    EXPECT_EQ(parse_tcp_address(text), std::nullopt) << text;
  }
}

TEST(TcpAddress, IsWrittenAsItIsRead) {
  for (const char* const text : {"127.0.0.1:29536", "[::1]:60000"}) {
    const auto address = parse_tcp_address(text);
    ASSERT_TRUE(address) << text;
    EXPECT_EQ(address_text(*address), text);
  }
}

}  // namespace
}  // namespace vdrive::canopen
