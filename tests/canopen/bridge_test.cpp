// SPDX-License-Identifier: Apache-2.0
// The bridge with benches in real time.
#include "canopen/bus_of_bench.hpp"
#include "settings/configuration_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using canopen::NmtState;
using testing::HasSubstr;

constexpr std::uint8_t kNmtStart = 0x01;
constexpr std::array<std::uint8_t, 3> kWordsToEnable{0x06, 0x07, 0x0F};

/// Waits until 6041h in the latest TPDO 1 has these bits.
/// @return false after 60 s.
bool wait_for_status(BusOfBench& bus, std::uint8_t node, std::uint16_t mask, std::uint16_t bits) {
  return bus.master().wait_until([&] {
    const auto status = bus.master().newest(0x180U + node);
    return status && (number_in(*status, 0, 2) & mask) == bits;
  });
}

TEST(Bridge, AnswersSdo) {
  BusOfBench bus(1);
  ASSERT_TRUE(bus.master().wait_for(0x701));
  EXPECT_EQ(bus.read(1, {0x1000, 0}), 0x00020192) << "a servo drive of CiA 402";
  EXPECT_EQ(bus.master().download(1, {0x6081, 0}, 12'345, 4), AbortCode::none);
  EXPECT_EQ(bus.read(1, {0x6081, 0}), 12'345);
  EXPECT_EQ(bus.master().download(1, {0x6041, 0}, 0, 2), AbortCode::write_of_read_only_object);
}

TEST(Bridge, EnablesByPdos) {
  BusOfBench bus(2);
  ASSERT_TRUE(bus.master().wait_for(0x702));
  bus.master().send_nmt(kNmtStart, 0);
  // A node boots before the bridge owns its axis; until then bit 9 (remote) is 0 and RPDOs are
  // ignored.
  for (const std::uint8_t node : {std::uint8_t{1}, std::uint8_t{2}}) {
    ASSERT_TRUE(wait_for_status(bus, node, Statusword::kRemote, Statusword::kRemote));
  }
  for (const std::uint8_t word : kWordsToEnable) {
    bus.master().send(0x201, {word, 0});
    bus.master().send(0x202, {word, 0});
  }
  EXPECT_TRUE(wait_for_status(bus, 1, kStateBits, kShowsEnabled)) << bus.bridge().bus(0).counters();
  EXPECT_TRUE(wait_for_status(bus, 2, kStateBits, kShowsEnabled)) << bus.bridge().bus(0).counters();
}

TEST(Bridge, SendsHeartbeats) {
  BusOfBench bus(1);
  ASSERT_TRUE(bus.master().wait_for(0x701));
  ASSERT_EQ(bus.master().download(1, {0x1017, 0}, 5, 2), AbortCode::none);
  (void)bus.master().take_all();
  EXPECT_TRUE(bus.master().wait_until([&bus] {
    return bus.master().count(0x701) >= 5;
  }));
  EXPECT_EQ(bus.master().newest(0x701)->data[0],
            static_cast<std::uint8_t>(NmtState::pre_operational));
}

/// Two benches on one bus.
TEST(Bridge, HasTheAxesOfSeveralBenchesOnOneBus) {
  const bench::Bench one({.axes = 2, .clock = ClockMode::realtime, .number = 1});
  const bench::Bench two({.axes = 2, .clock = ClockMode::realtime, .number = 2, .bus = one.bus()});
  canopen::Settings settings;
  settings.session.bus = one.bus();
  canopen::BusSetting& setting = settings.buses.emplace_back();
  setting.benches = {{.number = 1}, {.number = 2, .node_offset = 10}};
  canopen::CanopenBridge bridge(settings);
  TestMaster master(bridge.bus(0).bus(), [&bridge] {
    bridge.loop().run_one_for(std::chrono::milliseconds(10));
  });
  bridge.start();
  for (const std::uint32_t id : {0x701U, 0x702U, 0x70BU, 0x70CU}) {
    EXPECT_TRUE(master.wait_for(id)) << id;
  }
  EXPECT_EQ(master.upload(12, {0x1000, 0}).number(), 0x00020192);
}

// In lock-step both benches are found at the same time; the lower number takes precedence.
TEST(Bridge, LeavesOutABenchWhoseNodesAreTaken) {
  const bench::Bench one({.axes = 2, .clock = ClockMode::lockstep, .number = 1});
  const bench::Bench two({.axes = 3, .clock = ClockMode::lockstep, .number = 2, .bus = one.bus()});
  canopen::Settings settings;
  settings.session.bus = one.bus();
  settings.buses.emplace_back();  // every bench, without an offset
  canopen::CanopenBridge bridge(settings);
  bridge.start();
  ASSERT_EQ(bridge.bus(0).left_out().size(), 1U);
  EXPECT_THAT(bridge.bus(0).left_out().front(),
              HasSubstr("bench 2: axis 2.1 would be node 1, which is axis 1.1"));
  EXPECT_NE(bridge.bus(0).nodes(1), nullptr);
  EXPECT_EQ(bridge.bus(0).nodes(2), nullptr);
}

/// A client of the socketcand server receives the frames of the master on the bus, and vice versa.
TEST(Bridge, ListensWhereTheSettingsSay) {
  const bench::Bench bench({.axes = 1, .clock = ClockMode::realtime});
  canopen::Settings settings;
  settings.session.bus = bench.bus();
  canopen::BusSetting& setting = settings.buses.emplace_back();
  setting.socketcand.push_back({});
  setting.gateways.push_back({});
  const canopen::CanopenBridge bridge(settings);
  const std::string line = bridge.first_lines().front();
  EXPECT_THAT(line, HasSubstr(", socketcand 127.0.0.1:"));
  EXPECT_THAT(line, HasSubstr(", gateway 127.0.0.1:"));
  EXPECT_THAT(line, testing::Not(HasSubstr(":0,"))) << "the port that the system gave";
}

TEST(Bridge, FailsWhereItCannotListenWithTheAddress) {
  const bench::Bench bench({.axes = 1, .clock = ClockMode::realtime});
  canopen::Settings settings;
  settings.session.bus = bench.bus();
  settings.buses.emplace_back().socketcand.push_back({.host = "192.0.2.1", .port = 1});
  try {
    const canopen::CanopenBridge bridge(settings);
    FAIL() << "192.0.2.1 is no address of this machine (RFC 5737)";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("192.0.2.1:1"));
  }
}

TEST(PrivateBridge, MakesItsBenchAndHasItsNodesWhenItHasStarted) {
  canopen::Settings settings;
  settings.is_private = true;
  settings.clock = ClockMode::realtime;
  settings.buses.emplace_back().benches.push_back({.number = 1, .node_offset = 4, .axes = 3});
  canopen::CanopenBridge bridge(settings);
  bridge.start();
  EXPECT_TRUE(bridge.bus(0).are_all_there());
  EXPECT_THAT(bridge.first_lines().front(), HasSubstr("bus 1: 3 nodes (5 to 7)"));
}

TEST(PrivateBridge, RefusesAxesThatCannotBeNodes) {
  canopen::Settings settings;
  settings.is_private = true;
  settings.clock = ClockMode::realtime;
  settings.buses.emplace_back().benches.push_back({.number = 1, .node_offset = 126, .axes = 2});
  canopen::CanopenBridge bridge(settings);
  EXPECT_THROW(bridge.start(), vdrive::settings::ConfigurationError);
}

/// 6081h is not part of the status: the bridge reads it between ticks.
TEST(Bridge, SendsAParameterInATpdoWhenItChanges) {
  BusOfBench bus(1);
  ASSERT_TRUE(bus.master().wait_for(0x701));
  TestMaster& master = bus.master();
  ASSERT_EQ(master.download(1, {0x1800, 1}, 0x80000181, 4), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1A00, 0}, 0, 1), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1A00, 1}, 0x60810020, 4), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1A00, 0}, 1, 1), AbortCode::none);
  ASSERT_EQ(master.download(1, {0x1800, 1}, 0x181, 4), AbortCode::none);
  master.send_nmt(kNmtStart, 1);
  ASSERT_TRUE(master.wait_for(0x181));
  ASSERT_EQ(master.download(1, {0x6081, 0}, 4'321, 4), AbortCode::none);
  EXPECT_TRUE(master.wait_until([&master] {
    const auto sent = master.newest(0x181);
    return sent && sent->size == 4 && number_in(*sent, 0, 4) == 4'321;
  }));
}

TEST(Bridge, SaysWhichOfItsServersAreNotThere) {
  const bench::Bench bench({.axes = 1, .clock = ClockMode::realtime});
  canopen::Settings settings;
  settings.session.bus = bench.bus();
  settings.buses.emplace_back().gateways.push_back({});
  const canopen::CanopenBridge with_gateway(settings);
  EXPECT_THAT(with_gateway.first_lines().front(), HasSubstr(", no socketcand, session 0x"));
  settings.buses.front() = {};
  settings.buses.front().socketcand.push_back({});
  const canopen::CanopenBridge with_socketcand(settings);
  EXPECT_THAT(with_socketcand.first_lines().front(), HasSubstr(", no gateway, session 0x"));
}

}  // namespace
}  // namespace vdrive::test
