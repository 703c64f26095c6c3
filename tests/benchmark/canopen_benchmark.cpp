// SPDX-License-Identifier: Apache-2.0
//
// Cost of the nodes of a CANopen bus, without sockets and sessions: a SYNC with four TPDOs of each
// node and the tick after it, a frame for another node, an SDO round trip. Prints one JSON line for
// each figure: the median of the repetitions.
#include "figure_reporter.hpp"
#include "node/frame.hpp"
#include "node/node.hpp"
#include "node/node_host.hpp"
#include "vdrive/axis_bank.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace {

using namespace vdrive;
using namespace vdrive::canopen;

constexpr std::chrono::microseconds kPeriod{1000};
constexpr int kRepetitions = 9;
constexpr std::size_t kTransmitPdos = 4;
constexpr std::uint8_t kExpeditedAnswer = 0x4B;  ///< to an upload, with 2 bytes

Frame frame_of(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
  Frame frame{.id = id, .size = static_cast<std::uint8_t>(data.size())};
  std::ranges::copy(data, frame.data.begin());
  return frame;
}

/// An axis of a bank as a node. Counts the frames that it sends and keeps the last one.
class AxisNode final : public NodeHost {
 public:
  AxisNode(AxisBank& bank, std::size_t axis)
      : bank_(bank), axis_(axis), node_({.node_id = static_cast<std::uint8_t>(axis + 1)}, *this) {
    node_.start(view(), now_);
  }

  void receive(const Frame& frame) {
    node_.receive(frame, now_);
    if (!access_) return;
    const DriveAccess access = *std::exchange(access_, std::nullopt);
    node_.complete(access.ticket, answer_to(access), now_);
  }

  void show_tick(DriveTime now) {
    now_ = now;
    node_.update(view(), now);
    node_.advance(now);
  }

  [[nodiscard]] std::size_t sent() const { return sent_; }

  [[nodiscard]] const Frame& last() const { return last_; }

  void send(const Frame& frame) override {
    ++sent_;
    last_ = frame;
  }

  void begin_access(const DriveAccess& access) override { access_ = access; }

  void command(std::span<const DriveValue> values) override {
    for (const DriveValue& value : values) bank_.write(axis_, value.object, value.value);
  }

  void set_connection_lost(bool /*is_lost*/) override {}

  void power_cycle() override { bank_.power_cycle(axis_); }

  bool store(const std::map<ObjectAddress, std::uint32_t>& /*parameters*/) override { return true; }

 private:
  [[nodiscard]] DriveView view() const { return {.status = bank_.status(axis_)}; }

  [[nodiscard]] DriveAnswer answer_to(const DriveAccess& access) {
    if (access.value) return {.abort = bank_.write(axis_, access.object, *access.value)};
    const ReadResult read = bank_.read(axis_, access.object);
    return {.abort = read.code, .value = read.value};
  }

  AxisBank& bank_;
  std::size_t axis_;
  DriveTime now_{0};
  std::size_t sent_ = 0;
  Frame last_;
  std::optional<DriveAccess> access_;
  Node node_;
};

/// Nodes in Operational that send their TPDOs at each SYNC.
class NodesOfABank {
 public:
  explicit NodesOfABank(std::size_t count) : bank_(std::vector<AxisConfiguration>(count), kPeriod) {
    for (std::size_t axis = 0; axis < count; ++axis) {
      nodes_.push_back(std::make_unique<AxisNode>(bank_, axis));
    }
    for (std::size_t axis = 0; axis < count; ++axis) {
      const auto id = static_cast<std::uint32_t>(0x601 + axis);
      for (std::uint8_t number = 0; number < kTransmitPdos; ++number) {
        // 1800h.. :02, transmission type 1
        at(axis).receive(frame_of(id, {0x2F, number, 0x18, 0x02, 1, 0, 0, 0}));
      }
    }
    receive(frame_of(0x000, {0x01, 0x00}));  // NMT: start all nodes
  }

  [[nodiscard]] AxisNode& at(std::size_t axis) { return *nodes_.at(axis); }

  void receive(const Frame& frame) {
    for (const auto& node : nodes_) node->receive(frame);
  }

  /// Sends a SYNC and runs the tick after it.
  void synchronise() {
    receive(Frame{.id = 0x080});
    bank_.step();
    now_ += kPeriod;
    for (const auto& node : nodes_) node->show_tick(now_);
  }

  [[nodiscard]] std::size_t sent() const {
    std::size_t sum = 0;
    for (const auto& node : nodes_) sum += node->sent();
    return sum;
  }

 private:
  AxisBank bank_;
  std::vector<std::unique_ptr<AxisNode>> nodes_;
  DriveTime now_{0};
};

/// Reports the time of one of the `parts` equal parts of an iteration [ns].
void report(benchmark::State& state, std::size_t parts) {
  state.counters["value"] = benchmark::Counter(
      1.0e-9 * static_cast<double>(parts),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Measures each node's share of a SYNC and its tick.
void synchronise(benchmark::State& state) {
  const auto count = static_cast<std::size_t>(state.range(0));
  NodesOfABank nodes(count);
  const std::size_t before = nodes.sent();
  std::size_t rounds = 0;
  for (auto _ : state) {
    nodes.synchronise();
    ++rounds;
  }
  if (nodes.sent() - before != rounds * count * kTransmitPdos) {
    state.SkipWithError("a SYNC brings four TPDOs of each node");
  }
  report(state, count);
}

/// Measures the handling of another node's TPDO, which every node of a bus receives.
void ignore_frame(benchmark::State& state) {
  NodesOfABank nodes(1);
  const std::size_t before = nodes.sent();
  const Frame frame = frame_of(0x182, {0x50, 0x02});
  for (auto _ : state) nodes.at(0).receive(frame);
  if (nodes.sent() != before) state.SkipWithError("the frame is for nobody");
  report(state, 1);
}

/// Measures an SDO upload, from the request to the answer.
void read_object(benchmark::State& state, std::uint16_t index) {
  NodesOfABank nodes(1);
  const Frame request = frame_of(0x601, {0x40, static_cast<std::uint8_t>(index & 0xFF),
                                         static_cast<std::uint8_t>(index >> 8), 0, 0, 0, 0, 0});
  for (auto _ : state) nodes.at(0).receive(request);
  if (nodes.at(0).last().data[0] != kExpeditedAnswer) state.SkipWithError("no answer");
  report(state, 1);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RegisterBenchmark("canopen_sync_ns", synchronise)
      ->Arg(3)
      ->Arg(32)
      ->Arg(127)
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("canopen_foreign_frame_ns", ignore_frame)->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("canopen_sdo_of_drive_ns", read_object, std::uint16_t{0x6041})
      ->Repetitions(kRepetitions);
  benchmark::RegisterBenchmark("canopen_sdo_of_node_ns", read_object, std::uint16_t{0x1017})
      ->Repetitions(kRepetitions);
  vdrive::test::FigureReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  benchmark::Shutdown();
  return reporter.failed() ? 1 : 0;
}
