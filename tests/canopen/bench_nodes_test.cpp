// SPDX-License-Identifier: Apache-2.0
// The nodes of a bench on their bus, without the bench.
#include "bridge/bench_nodes.hpp"

#include "canopen/recorded_port.hpp"
#include "support/temporary_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace vdrive::canopen {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// Node 1 and a master on a bus. What the node asks of its drive is kept.
struct NodeOnABus {
  static constexpr std::uint64_t kSession = 7;

  /// @param state of NodeStore
  explicit NodeOnABus(const std::filesystem::path& state = {}) : store(state, "left", reports) {
    drives[0].owner_session = kSession;
    start();
  }

  void start() {
    nodes.start(drives, DriveTime::zero());
    master.frames.clear();
  }

  void set_owner(std::uint64_t session) {
    drives[0].owner_session = session;
    nodes.update(drives, DriveTime::zero());
  }

  std::vector<DriveAccess> accesses{};
  std::deque<bool> told{};  ///< of the connection to a master
  bridge::Reports reports{"test", [](bridge::Severity, const std::string&) {}};
  NodeStore store;
  Bus bus{};
  RecordedPort master{bus};
  std::array<NodePlace, 1> places{NodePlace{.axis = 1, .node_id = 1}};
  BenchNodes nodes{bus,
                   store,
                   places,
                   {.session = kSession},
                   {.access =
                        [this](std::size_t, const DriveAccess& access) {
                          accesses.push_back(access);
                        },
                    .tell_connection =
                        [this](std::size_t, bool is_lost) {
                          told.push_back(is_lost);
                        },
                    .cycle_power = [](std::size_t) {},
                    .set_points = [] {},
                    .sync = {}}};
  std::array<client::AxisSnapshot, 1> drives{};
};

// A bench that ends leaves calls that are answered when they have timed out.
TEST(BenchNodes, IgnoreTheAnswerToAnAccessOfANodeThatIsGone) {
  NodeOnABus test;
  test.master.send(data_frame(0x601, {0x40, 0x41, 0x60, 0x00, 0, 0, 0, 0}));
  test.nodes.stop();
  test.start();
  test.master.send(data_frame(0x601, {0x40, 0x64, 0x60, 0x00, 0, 0, 0, 0}));
  ASSERT_THAT(test.accesses, SizeIs(2));
  test.nodes.complete(0, test.accesses[0].ticket, {.abort = AbortCode::cannot_store_or_transfer});
  EXPECT_THAT(test.master.frames, IsEmpty());
  test.nodes.complete(0, test.accesses[1].ticket, {.value = 2});
  EXPECT_THAT(test.master.frames,
              ElementsAre(data_frame(0x581, {0x43, 0x64, 0x60, 0x00, 2, 0, 0, 0})));
}

TEST(BenchNodes, AnswerASaveThatCannotBeWrittenWithAHardwareError) {
  const test::TemporaryDirectory directory;
  std::ofstream(directory.path() / "state") << "";
  NodeOnABus test(directory.path() / "state");  // no directory
  test.master.send(data_frame(0x601, {0x2B, 0x17, 0x10, 0x00, 0x64, 0, 0, 0}));
  test.master.frames.clear();
  for (const bool is_directory : {false, true}) {
    if (is_directory) std::filesystem::remove(directory.path() / "state");
    test.master.send(data_frame(0x601, {0x23, 0x10, 0x10, 0x01, 0x73, 0x61, 0x76, 0x65}));
    test.nodes.complete(0, test.accesses.back().ticket, {});
  }
  EXPECT_THAT(test.master.frames,
              ElementsAre(data_frame(0x581, {0x80, 0x10, 0x10, 0x01, 0x00, 0x00, 0x06, 0x06}),
                          data_frame(0x581, {0x60, 0x10, 0x10, 0x01, 0, 0, 0, 0})));
}

TEST(BenchNodes, TellTheLossOfAMasterWhenControlIsBackAndTheMasterIsNot) {
  NodeOnABus test;
  test.master.send(data_frame(0x000, {0x01, 1}));
  test.set_owner(NodeOnABus::kSession + 1);
  test.master.send(data_frame(0x000, {0x02, 1}));  // NMT stop
  EXPECT_THAT(test.told, IsEmpty());
  test.set_owner(NodeOnABus::kSession);
  EXPECT_THAT(test.told, ElementsAre(true));
  test.set_owner(NodeOnABus::kSession);
  EXPECT_THAT(test.told, ElementsAre(true)) << "once";
}

TEST(BenchNodes, TellNoLossThatHasEndedWhenControlIsBack) {
  NodeOnABus test;
  test.master.send(data_frame(0x000, {0x01, 1}));
  test.set_owner(NodeOnABus::kSession + 1);
  test.master.send(data_frame(0x000, {0x02, 1}));
  test.master.send(data_frame(0x000, {0x01, 1}));
  test.set_owner(NodeOnABus::kSession);
  EXPECT_THAT(test.told, ElementsAre(false));
}

TEST(BenchNodes, AnswerEachRequestByItsOwnAccess) {
  NodeOnABus test;
  test.master.send(data_frame(0x601, {0x40, 0x41, 0x60, 0x00, 0, 0, 0, 0}));
  test.master.send(data_frame(0x601, {0x40, 0x64, 0x60, 0x00, 0, 0, 0, 0}));
  ASSERT_THAT(test.accesses, SizeIs(1));
  test.nodes.complete(0, test.accesses[0].ticket, {.value = 0x0250});
  ASSERT_THAT(test.accesses, SizeIs(2));
  test.nodes.complete(0, test.accesses[0].ticket, {.value = 7});
  test.nodes.complete(0, test.accesses[1].ticket, {.value = 2});
  EXPECT_THAT(test.master.frames,
              ElementsAre(data_frame(0x581, {0x4B, 0x41, 0x60, 0x00, 0x50, 0x02, 0, 0}),
                          data_frame(0x581, {0x43, 0x64, 0x60, 0x00, 2, 0, 0, 0})));
}

}  // namespace
}  // namespace vdrive::canopen
