// SPDX-License-Identifier: Apache-2.0
// The nodes of a bench on their bus, without the bench.
#include "bridge/bench_nodes.hpp"

#include "canopen/recorded_port.hpp"
#include "support/temporary_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vdrive::canopen {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

/// Node 1 and a master on a bus; records the node's requests to its drive.
struct NodeOnABus final : NodeDrives {
  static constexpr std::uint64_t kSession = 7;

  /// @param state directory of NodeStore
  explicit NodeOnABus(const std::filesystem::path& state = {}) : store(state, "left", reports) {
    drives[0].owner_session = kSession;
    start();
  }

  void start(DriveTime now = {}) {
    nodes.start(drives, now);
    master.frames.clear();
  }

  void disturb(std::string_view text) {
    const auto fault = std::get<BusFault>(parse_fault_of_node(text));
    EXPECT_TRUE(bus.faults().add(fault, DriveTime::zero()));
  }

  /// @return whether the node answers a read of 1017h, which the drive does not have.
  bool answers() {
    master.frames.clear();
    master.send(data_frame(0x601, {0x40, 0x17, 0x10, 0x00, 0, 0, 0, 0}));
    return !master.frames.empty();
  }

  void set_owner(std::uint64_t session) {
    drives[0].owner_session = session;
    nodes.update(drives, DriveTime::zero());
  }

  void show(DriveTime now) { nodes.update(drives, now); }

  /// Maps 607Ah alone into TPDO1.
  void map_target() {
    master.send(data_frame(0x601, {0x23, 0x00, 0x18, 0x01, 0x81, 0x01, 0x00, 0x80}));
    master.send(data_frame(0x601, {0x2F, 0x00, 0x1A, 0x00, 0, 0, 0, 0}));
    master.send(data_frame(0x601, {0x23, 0x00, 0x1A, 0x01, 0x20, 0x00, 0x7A, 0x60}));
    master.send(data_frame(0x601, {0x2F, 0x00, 0x1A, 0x00, 1, 0, 0, 0}));
    master.send(data_frame(0x601, {0x23, 0x00, 0x18, 0x01, 0x81, 0x01, 0x00, 0x00}));
    master.frames.clear();
  }

  /// A request of the nodes to read values.
  struct Question {
    std::uint32_t ticket = 0;
    std::vector<ObjectAddress> objects{};
  };

  void answer(const Question& question, std::int64_t value) {
    const std::array<DriveValue, 1> values{
        DriveValue{.object = question.objects.front(), .value = value}};
    nodes.take_values(0, question.ticket, values);
  }

  void access(std::size_t /*place*/, const DriveAccess& asked) override {
    accesses.push_back(asked);
  }

  void tell_connection(std::size_t /*place*/, bool is_lost) override { told.push_back(is_lost); }

  void cycle_power(std::size_t /*place*/) override {}

  void note_set_points() override {}

  void read(std::size_t /*place*/, std::uint32_t ticket,
            const std::vector<ObjectAddress>& objects) override {
    questions.push_back({.ticket = ticket, .objects = objects});
  }

  std::vector<Question> questions{};
  std::vector<DriveAccess> accesses{};
  std::deque<bool> told{};  ///< reported states of the connection to a master
  bridge::Reports reports{"test", [](bridge::Severity, const std::string&) {}};
  NodeStore store;
  Bus bus{};
  RecordedPort master{bus};
  std::array<NodePlace, 1> places{NodePlace{.axis = 1, .node_id = 1}};
  BenchNodes nodes{bus, store, *this, places, {.session = kSession, .read_period = 10ms}};
  std::array<client::AxisSnapshot, 1> drives{};
};

// When a bench ends, its outstanding calls are answered only after they have timed out.
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

TEST(BenchNodes, AskForWhatTheStatusDoesNotHaveAtOnceAndThenOnceAPeriod) {
  NodeOnABus test;
  EXPECT_THAT(test.questions, IsEmpty()) << "the status has what TPDOs carry by default";
  test.map_target();
  ASSERT_THAT(test.questions, SizeIs(1)) << "without a tick";
  EXPECT_THAT(test.questions[0].objects, ElementsAre(ObjectAddress{0x607A, 0}));
  test.answer(test.questions[0], 7);
  test.show(9ms);
  EXPECT_THAT(test.questions, SizeIs(1));
  test.show(10ms);
  EXPECT_THAT(test.questions, SizeIs(2));
}

TEST(BenchNodes, AskForNothingWhileAnAnswerIsUnderWay) {
  NodeOnABus test;
  test.map_target();
  test.show(50ms);
  ASSERT_THAT(test.questions, SizeIs(1));
  test.nodes.take_values(0, test.questions[0].ticket, {});  // the bench has not answered
  test.show(60ms);
  EXPECT_THAT(test.questions, SizeIs(2));
}

TEST(BenchNodes, SendAReadValueWithTheNextTick) {
  NodeOnABus test;
  test.map_target();
  test.master.send(data_frame(0x000, {0x01, 1}));
  test.show(1ms);
  EXPECT_THAT(test.master.frames, Not(Contains(Field(&Frame::id, 0x181U)))) << "it has no value";
  ASSERT_THAT(test.questions, SizeIs(1));
  test.answer(test.questions[0], 7);
  EXPECT_THAT(test.master.frames, Not(Contains(Field(&Frame::id, 0x181U))));
  test.show(2ms);
  EXPECT_THAT(test.master.frames, Contains(data_frame(0x181, {7, 0, 0, 0})));
}

TEST(BenchNodes, IgnoreAValueThatWasAskedForByANodeThatIsGone) {
  NodeOnABus test;
  test.map_target();
  test.start();
  test.map_target();
  ASSERT_THAT(test.questions, SizeIs(2));
  test.answer(test.questions[0], 7);
  test.master.send(data_frame(0x000, {0x01, 1}));
  test.show(1ms);
  EXPECT_THAT(test.master.frames, Not(Contains(Field(&Frame::id, 0x181U))));
}

constexpr DriveTime kSince1970 = 1'700'000'000s;  // ticks in real time count since 1970

TEST(BenchNodes, CountTheTimeOfFaultsSinceTheyCameToTheBus) {
  NodeOnABus test;
  test.start(kSince1970);
  test.disturb("lost from 2s for 500ms");
  const auto answers_at = [&test](DriveTime time) {
    test.show(kSince1970 + time);
    return test.answers();
  };
  EXPECT_TRUE(answers_at(1'999ms));
  EXPECT_FALSE(answers_at(2s));
  EXPECT_FALSE(answers_at(2'499ms));
  EXPECT_TRUE(answers_at(2'500ms));
}

TEST(BenchNodes, AreOffTheBusWhileAFaultOfRealTimeLasts) {
  NodeOnABus test;
  test.start(kSince1970);
  test.disturb("bus_off for 5s");
  test.show(kSince1970 + 1ms);
  EXPECT_FALSE(test.answers());
  test.show(kSince1970 + 5s);
  EXPECT_THAT(test.master.frames, Contains(Field(&Frame::id, 0x081U))) << "8140h";
}

TEST(BenchNodes, ShareTheTimeOfFaultsWithThoseThatCameFirst) {
  NodeOnABus test;
  test.start(kSince1970);
  test.show(kSince1970 + 10s);
  const std::array<NodePlace, 1> places{NodePlace{.axis = 1, .node_id = 2}};
  BenchNodes later(test.bus, test.store, test, places, {.session = NodeOnABus::kSession});
  later.start(test.drives, kSince1970 + 10s);
  EXPECT_EQ(later.fault_time(), 10s);
  later.update(test.drives, kSince1970 + 12s);
  EXPECT_EQ(test.bus.faults().now(), 12s);
}

TEST(BenchNodes, KeepTheTimeOfFaultsWhenTheirDrivesComeBack) {
  NodeOnABus test;
  test.start(kSince1970);
  test.show(kSince1970 + 3s);
  test.start(kSince1970 + 60s);
  EXPECT_EQ(test.nodes.fault_time(), 3s);
  test.start(kSince1970 - 60s);
  EXPECT_EQ(test.nodes.fault_time(), 3s) << "the clock was set back";
}

TEST(BenchNodes, CountWhatTheirDrivesRefuseAlsoOfNodesThatAreGone) {
  NodeOnABus test;
  test.nodes.note_refused_set_points(1, 3);
  test.nodes.note_refused_set_points(2, 5);  // not an axis of this bench
  EXPECT_EQ(test.nodes.counters().refused_set_points, 3U);
  test.nodes.stop();
  EXPECT_EQ(test.nodes.counters().refused_set_points, 3U);
}

}  // namespace
}  // namespace vdrive::canopen
