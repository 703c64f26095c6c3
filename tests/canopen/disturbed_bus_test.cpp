// SPDX-License-Identifier: Apache-2.0
// Nodes on a disturbed bus. Each SYNC lets 1 ms of drive time pass.
#include "canopen/bus_of_bench.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using canopen::Frame;
using canopen::NmtState;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::uint8_t kStartNode = 0x01;  // NMT command

/// Nodes in Operational that send TPDO1 (6041h) at each SYNC.
class DisturbedBus {
 public:
  explicit DisturbedBus(std::size_t axes = 1) : bus_(axes, 1ms) {
    for (std::uint8_t node = 1; node <= axes; ++node) {
      EXPECT_EQ(bus_.master().download(node, {0x1800, 2}, 1, 1), AbortCode::none);
      for (const std::uint16_t other : std::array<std::uint16_t, 3>{0x1801, 0x1802, 0x1803}) {
        const std::int64_t cob_id = bus_.read(node, {other, 1}) | 0x80000000;
        EXPECT_EQ(bus_.master().download(node, {other, 1}, cob_id, 4), AbortCode::none);
      }
    }
    bus_.master().send_nmt(kStartNode, 0);
    (void)bus_.master().take_all();
  }

  void disturb(std::string_view text) {
    auto fault = std::get<canopen::BusFault>(canopen::parse_fault_of_node(text));
    const canopen::DriveTime start = now();
    fault.from += start;
    if (fault.until) *fault.until += start;
    EXPECT_TRUE(faults().add(fault, start));
  }

  /// @return the frames that the master receives during this many SYNCs.
  std::vector<Frame> sync(int count = 1) {
    bus_.sync(count);
    return bus_.master().take_all();
  }

  [[nodiscard]] canopen::DriveTime now() { return bus_.nodes().now(); }

  [[nodiscard]] canopen::BusFaults& faults() { return bus_.bridge().bus(0).bus().faults(); }

  [[nodiscard]] BusOfBench& bench() noexcept { return bus_; }

  [[nodiscard]] const canopen::Node& node(std::size_t place) { return *bus_.nodes().node(place); }

 private:
  BusOfBench bus_;
};

std::size_t count_of(const std::vector<Frame>& frames, std::uint32_t id) {
  return static_cast<std::size_t>(std::ranges::count(frames, id, &Frame::id));
}

TEST(DisturbedBus, LosesWhatANodeSendsAndLeavesTheOthersAlone) {
  DisturbedBus bus(2);
  bus.disturb("1 lost sent for 3ms");
  const std::vector<Frame> lost = bus.sync(3);
  EXPECT_EQ(count_of(lost, 0x181), 0U);
  EXPECT_EQ(count_of(lost, 0x182), 3U);
  EXPECT_EQ(count_of(bus.sync(2), 0x181), 2U) << "it has ended";
  EXPECT_EQ(bus.faults().disturbed_frames(), 3U);
}

// The master's SYNC defines the time: even when the nodes do not receive it, the drives step.
TEST(DisturbedBus, LetsTimePassWithASyncThatTheNodesDoNotReceive) {
  DisturbedBus bus;
  const canopen::DriveTime before = bus.now();
  bus.disturb("lost received for 3ms");
  EXPECT_THAT(bus.sync(3), IsEmpty());
  EXPECT_EQ(bus.now() - before, 3ms);
  EXPECT_THAT(bus.sync(), SizeIs(1));
}

TEST(DisturbedBus, DoublesFrames) {
  DisturbedBus bus;
  bus.disturb("doubled sent");
  EXPECT_THAT(bus.sync(), SizeIs(2));
  bus.faults().clear(0);
  bus.disturb("doubled received");
  const canopen::DriveTime before = bus.now();
  EXPECT_THAT(bus.sync(), SizeIs(2)) << "two SYNCs have a TPDO each";
  EXPECT_EQ(bus.now() - before, 1ms) << "and one has let time pass";
}

TEST(DisturbedBus, DeliversLateFramesWhenTheirTimeHasCome) {
  DisturbedBus bus;
  bus.disturb("late 2ms sent");
  EXPECT_THAT(bus.sync(), IsEmpty());
  EXPECT_THAT(bus.sync(), SizeIs(1)) << "2 ms after the first SYNC";
  EXPECT_THAT(bus.sync(), SizeIs(1));
  bus.faults().clear(0);
  EXPECT_THAT(bus.sync(), SizeIs(2)) << "that of the second SYNC before, and that of this one";
}

TEST(DisturbedBus, ReceivesLateFramesWhenTheirTimeHasCome) {
  DisturbedBus bus;
  bus.disturb("1 late 3ms received");
  bus.bench().master().send_nmt(0x80, 1);
  bus.sync(2);
  EXPECT_EQ(bus.node(0).state(), NmtState::operational);
  bus.sync();
  EXPECT_EQ(bus.node(0).state(), NmtState::pre_operational);
}

TEST(DisturbedBus, HasTheSameFramesInEachRun) {
  const auto run = [](const std::string& seed) {
    DisturbedBus bus(3);
    bus.disturb("lost 20% seed " + seed);
    bus.disturb("late 2ms 20% seed " + seed);
    bus.disturb("2 doubled 20% seed " + seed);
    return bus.sync(200);
  };
  const std::vector<Frame> frames = run("1");
  EXPECT_EQ(run("1"), frames);
  EXPECT_NE(run("2"), frames);
}

// 1029h:01 = 0: the node changes to Pre-operational. Its drive reports a lost master, but not as
// fault 8130h (6007h), because it is not enabled. 8140h is sent when the node is back on the bus.
TEST(DisturbedBus, TakesANodeOffTheBusAndBack) {
  DisturbedBus bus(2);
  bus.disturb("1 bus_off for 5ms");
  bus.sync(4);
  EXPECT_EQ(bus.node(0).state(), NmtState::pre_operational);
  EXPECT_EQ(bus.node(1).state(), NmtState::operational);
  bus.bench().master().send_nmt(kStartNode, 1);
  bus.bench().sync();
  EXPECT_EQ(bus.node(0).state(), NmtState::pre_operational) << "it hears nothing";
  const bool is_reported =
      std::ranges::any_of(bus.bench().master().take_all(), [](const Frame& frame) {
        return frame.id == 0x081 && number_in(frame, 0, 2) == 0x8140;
      });
  EXPECT_TRUE(is_reported) << "5 ms have passed";
  bus.bench().master().send_nmt(kStartNode, 1);
  EXPECT_EQ(bus.node(0).state(), NmtState::operational);
}

TEST(DisturbedBus, StaysAsItIsWhere1029hSaysSo) {
  DisturbedBus bus;
  EXPECT_EQ(bus.bench().master().download(1, {0x1029, 1}, 1, 1), AbortCode::none);
  bus.disturb("bus_off for 2ms");
  bus.sync(3);
  EXPECT_EQ(bus.node(0).state(), NmtState::operational);
  EXPECT_EQ(count_of(bus.sync(), 0x181), 1U);
}

TEST(DisturbedBus, LosesTheMasterOfAnEnabledDriveWithBusOff) {
  DisturbedBus bus;
  for (const std::uint8_t word : std::array<std::uint8_t, 3>{0x06, 0x07, 0x0F}) {
    bus.bench().master().send(0x201, {word, 0});
    bus.sync();
  }
  ASSERT_EQ(bus.bench().statusword(1) & kStateBits, kShowsEnabled);
  bus.disturb("bus_off for 3ms");
  bus.sync(20);
  EXPECT_EQ(bus.bench().statusword(1) & kStateBits, kShowsFault) << "6007h = 1";
  EXPECT_EQ(bus.bench().read(1, {0x603F, 0}), 0x8130);
}

// 6060h of the axis is 3; the other device has the default.
TEST(DisturbedBus, HasASecondDeviceWithTheIdOfANode) {
  DisturbedBus bus(2);
  ASSERT_EQ(bus.bench().master().download(1, {0x6060, 0}, 3, 1), AbortCode::none);
  bus.disturb("1 duplicate");
  const std::vector<Frame> frames = bus.sync();
  EXPECT_EQ(count_of(frames, 0x701), 1U) << "it boots";
  bus.bench().master().send(0x601, {0x40, 0x60, 0x60, 0, 0, 0, 0, 0});
  std::vector<std::int64_t> answers;
  for (const Frame& frame : bus.bench().master().take_all()) {
    if (frame.id == 0x581) answers.push_back(number_in(frame, 4, 1));
  }
  EXPECT_THAT(answers, ElementsAre(0, 3)) << "it need not ask a drive, and is the first";
  bus.bench().master().send(0x602, {0x40, 0x60, 0x60, 0, 0, 0, 0, 0});
  EXPECT_EQ(bus.bench().master().take_all().size(), 1U);
  bus.faults().clear(1);
  bus.sync();
  (void)bus.bench().master().take_all();
  bus.bench().master().send(0x601, {0x40, 0x60, 0x60, 0, 0, 0, 0, 0});
  EXPECT_THAT(bus.bench().master().take_all(), SizeIs(1)) << "it has gone";
}

}  // namespace
}  // namespace vdrive::test
