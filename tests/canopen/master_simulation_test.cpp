// SPDX-License-Identifier: Apache-2.0
// Random masters, by seed: SDO, PDO, NMT, SYNC, heartbeats and noise in any order, sent to a node
// whose drive is an axis of the core. Checks after each frame and tick that no invariant of the
// drive is broken and that every SDO request is answered or aborted.
//
// A seed takes some milliseconds: 100 by default, 1,000 with VDRIVE_FULL, 10,000 nightly. A
// failing seed is printed; the environment variable VDRIVE_MASTER_SEED=<seed> runs it alone.
#include "canopen/fake_host.hpp"
#include "node/node.hpp"
#include "node/node_object.hpp"
#include "support/effort.hpp"
#include "support/programs/generator.hpp"
#include "support/programs/model.hpp"
#include "support/random_cases.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive::canopen {
namespace {

using std::chrono::microseconds;
using test::Random;

constexpr microseconds kTick{1000};
constexpr std::uint64_t kTicksOfASeed = 500;
constexpr std::uint8_t kSimulatedNode = 3;
constexpr std::uint32_t kRequestId = 0x600 + kSimulatedNode;
constexpr std::uint32_t kResponseId = 0x580 + kSimulatedNode;
constexpr std::uint32_t kNodeHeartbeatId = 0x700 + kSimulatedNode;
constexpr std::int64_t kMostOutstanding = 17;  // one in progress and 16 waiting

constexpr ObjectAddress kControlword{0x6040, 0};
constexpr ObjectAddress kAbortConnection{0x6007, 0};
constexpr ObjectAddress kStatuswordBits{0x5E20, 0x0C};
constexpr ObjectAddress kControlwordLoop{0x5E20, 0x06};
constexpr ObjectAddress kPowerOnTime{0x5E20, 0x07};
constexpr ObjectAddress kFaultResetDelay{0x5E20, 0x09};

/// The first broken invariant.
class Verdict {
 public:
  void demand(bool holds, std::string_view invariant) {
    if (!holds && broken_.empty()) broken_ = invariant;
  }

  /// @param violated an invariant; nullptr = none
  void note(const char* violated) {
    if (violated != nullptr) demand(false, violated);
  }

  [[nodiscard]] const std::string& broken() const { return broken_; }

 private:
  std::string broken_;
};

/// The drive side of a node: one axis of the core.
class SimulatedDrive final : public NodeHost {
 public:
  explicit SimulatedDrive(Verdict& verdict) : verdict_(verdict) {}

  void send(const Frame& frame) override { frames_.push_back(frame); }

  void begin_access(const DriveAccess& access) override {
    verdict_.demand(!access_, "a node has one access under way");
    access_ = access;
  }

  void command(std::span<const DriveValue> values) override {
    for (const DriveValue& value : values) {
      if (value.object != kControlword) write(value.object, value.value);
    }
    for (const DriveValue& value : values) {
      if (value.object == kControlword) write(value.object, value.value);
    }
  }

  void set_connection_lost(bool is_lost) override {
    verdict_.demand(is_lost || is_lost_, "only a lost connection comes back");
    is_lost_ = is_lost;
    if (is_lost) lose_connection();
  }

  void power_cycle() override {
    bank_.power_cycle(0);
    power_.forget_enabling();
    power_.forget_reset();
    is_cycled_ = true;
  }

  bool store(const std::map<ObjectAddress, std::uint32_t>& /*parameters*/) override { return true; }

  /// @return the arguments for Node::complete(); std::nullopt if no access is in progress.
  std::optional<std::pair<std::uint32_t, DriveAnswer>> answer_access() {
    if (!access_) return std::nullopt;
    const DriveAccess access = *std::exchange(access_, std::nullopt);
    DriveAnswer answer;
    if (!access.value) {
      const ReadResult result = bank_.read(0, access.object);
      answer = {.abort = result.code, .value = result.value};
    } else if (!is_owned && has_role(access.object, Role::command)) {
      answer.abort = AbortCode::refused_local_control;
    } else {
      answer.abort = write(access.object, *access.value);
    }
    return std::pair(access.ticket, answer);
  }

  DriveView step() {
    bank_.step();
    const AxisStatus& status = bank_.status(0);
    verdict_.note(power_.check(status, state(), std::exchange(is_cycled_, false),
                               bank_.read(0, kStatuswordBits).value));
    return {.status = status, .is_owned = is_owned};
  }

  [[nodiscard]] const AxisStatus& status() const { return bank_.status(0); }

  [[nodiscard]] PowerState state() const { return bank_.power_state(0); }

  std::vector<Frame> take() { return std::exchange(frames_, {}); }

  bool is_owned = true;

 private:
  AbortCode write(ObjectAddress object, std::int64_t value) {
    const auto [code, violated] = test::write_to(bank_, 0, {object, value});
    verdict_.note(violated);
    if (code != AbortCode::none) return code;
    if (object == kControlword) {
      power_.expect_enabling(enabling_delay());
      power_.expect_reset(reset_delay());
    } else if (object.index == kControlwordLoop.index) {
      // A controlword that waits for the drive to look at it is executed with the delays then in
      // force.
      if (power_.may_enable()) power_.expect_enabling(enabling_delay());
      if (power_.may_reset()) power_.expect_reset(reset_delay());
    }
    return code;
  }

  /// 5E20h delays a controlword until the drive looks at it; then the power stage needs its own
  /// time.
  [[nodiscard]] std::uint64_t enabling_delay() {
    return delay(kControlwordLoop) + delay(kPowerOnTime);
  }

  /// The same for a fault reset.
  [[nodiscard]] std::uint64_t reset_delay() {
    return delay(kControlwordLoop) + delay(kFaultResetDelay);
  }

  /// @return an object of 5E20h in ticks; a tick equals its unit, 1 ms.
  [[nodiscard]] std::uint64_t delay(ObjectAddress object) {
    static_assert(kTick == std::chrono::milliseconds{1});
    return static_cast<std::uint64_t>(bank_.read(0, object).value);
  }

  void lose_connection() {
    const PowerState before = bank_.power_state(0);
    const std::int64_t reaction = bank_.read(0, kAbortConnection).value;
    bank_.report_connection_loss(0);
    const PowerState after = bank_.power_state(0);
    if (reaction != 0) power_.forget_enabling();  // after a loss no waiting word may enable
    verdict_.demand(
        test::reacts_to_loss(reaction, before, after) && (reaction != 0 || after == before),
        test::Invariant::kReaction);
  }

  Verdict& verdict_;
  AxisConfiguration configuration_;
  AxisBank bank_{std::span(&configuration_, 1), kTick};
  test::PowerModel power_;
  std::vector<Frame> frames_;
  std::optional<DriveAccess> access_;
  bool is_lost_ = false;
  bool is_cycled_ = false;  ///< since the last tick
};

/// Random frames: of a master that watches the drive, and of masters that do not.
class RandomMaster {
 public:
  RandomMaster(const SimulatedDrive& drive, Random& random) : drive_(drive), random_(random) {}

  Frame next() {
    switch (random_.below(12)) {
      case 0:
      case 1:
        return read();
      case 2:
      case 3:
        return write();
      case 4:
        return useful_write();
      case 5:
        return segment();
      case 6:
      case 7:
        return receive_pdo();
      case 8:
        return {.id = 0x080, .size = static_cast<std::uint8_t>(random_.below(2)), .data = {1}};
      case 9:
        return {.id = 0x709, .size = 1, .data = {0x05}};
      case 10:
        return random_.one_in(4) ? nmt() : read();
      default:
        return random_.one_in(4) ? noise() : useful_write();
    }
  }

 private:
  const NodeObject& any_object() { return random_.pick(node_objects()); }

  static Frame request(std::uint8_t command, ObjectAddress object, std::uint32_t value = 0) {
    Frame frame{.id = kRequestId, .size = kMostData};
    frame.data[0] = command;
    frame.data[1] = static_cast<std::uint8_t>(object.index & 0xFFU);
    frame.data[2] = static_cast<std::uint8_t>(object.index >> 8U);
    frame.data[3] = object.subindex;
    for (unsigned i = 0; i < 4; ++i) {
      frame.data[4 + i] = static_cast<std::uint8_t>(value >> (8U * i) & 0xFFU);
    }
    return frame;
  }

  Frame read() { return request(0x40, any_object().address); }

  /// Expedited, sometimes with a wrong size.
  Frame write() {
    const NodeObject& object = any_object();
    std::uint32_t value = random_.word();
    if (random_.one_in(3)) value = static_cast<std::uint32_t>(object.default_value);
    unsigned size = size_of(object.data_type);
    if (random_.one_in(16)) size = 1U + static_cast<unsigned>(random_.below(4));
    if (size == 0) return request(0x21, object.address, value);
    return request(static_cast<std::uint8_t>(0x23U | (4U - size) << 2U), object.address, value);
  }

  /// Expedited, with the correct size.
  static Frame write_of(const test::Write& write) {
    const unsigned size = size_of(find_node_object(write.object)->data_type);
    return request(static_cast<std::uint8_t>(0x23U | (4U - size) << 2U), write.object,
                   static_cast<std::uint32_t>(write.value));
  }

  /// A write that moves the axis or changes the communication of the node.
  Frame useful_write() {
    switch (random_.below(10)) {
      case 0:
        return write_of({{0x1016, 1}, 0x9'0000 + random_.between(0, 39)});
      case 1:
        return write_of({{0x1029, 1}, random_.between(0, 2)});
      case 2:
        return random_.one_in(2) ? write_of({{0x1010, 1}, 0x6576'6173})
                                 : write_of({{0x1011, 1}, 0x6461'6F6C});
      default:
        return write_of(random_.one_in(50) ? test::Write{{0x6086, 0}, random_.one_in(2) ? 0 : 3}
                                           : test::draw_write(drive_.status(), random_));
    }
  }

  /// Begins, continues or aborts a segmented transfer.
  Frame segment() {
    constexpr std::array<std::uint8_t, 10> kCommands{0x20, 0x21, 0x00, 0x10, 0x07,
                                                     0x1B, 0x60, 0x70, 0x80, 0xA4};
    const std::uint8_t command = random_.pick<std::uint8_t>(kCommands);
    const ObjectAddress object = any_object().address;
    return request(command, object, static_cast<std::uint32_t>(random_.below(6)));
  }

  Frame receive_pdo() {
    constexpr std::array<std::uint8_t, 4> kSizes{2, 3, 6, 6};  // of the default mappings
    constexpr std::size_t kModePdo = 1;                        // 6040h and 6060h
    constexpr std::array<std::uint8_t, 9> kWords{0x06, 0x07, 0x0F, 0x0F, 0x1F,
                                                 0x3F, 0x7F, 0x80, 0x00};
    const std::size_t number = random_.below(kSizes.size());
    Frame frame{.id = 0x200U + 0x100U * static_cast<std::uint32_t>(number) + kSimulatedNode,
                .size = kSizes.at(number)};
    for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(random_.below(4));
    frame.data[0] = random_.pick<std::uint8_t>(kWords);
    frame.data[1] = random_.one_in(8) ? 1 : 0;
    if (number == kModePdo) frame.data[2] = static_cast<std::uint8_t>(test::draw_mode(random_));
    if (random_.one_in(20)) frame.size = static_cast<std::uint8_t>(random_.below(9));
    return frame;
  }

  Frame nmt() {
    constexpr std::array<std::uint8_t, 8> kCommands{0x01, 0x01, 0x01, 0x02, 0x80, 0x81, 0x82, 0x55};
    constexpr std::array<std::uint8_t, 4> kNodes{kSimulatedNode, kSimulatedNode, 0, 7};
    return {.id = 0,
            .size = 2,
            .data = {random_.pick<std::uint8_t>(kCommands), random_.pick<std::uint8_t>(kNodes)}};
  }

  Frame noise() {
    Frame frame{.id = static_cast<std::uint32_t>(random_.below(0x800)),
                .is_extended = random_.one_in(8),
                .is_remote = random_.one_in(8),
                .size = static_cast<std::uint8_t>(random_.below(9))};
    if (random_.one_in(3)) frame.id = kRequestId;
    for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(random_.below(256));
    // A block transfer does not have one response per request, so none is started.
    const bool is_block = frame.data[0] >> 5U == 6 || frame.data[0] >> 5U == 5;
    if (frame.id == kRequestId && is_block) frame.data[0] = 0xA0;
    return frame;
  }

  const SimulatedDrive& drive_;
  Random& random_;
};

/// Statistics of a seed.
struct MasterReport {
  std::string broken;  ///< the first broken invariant, with its tick; empty = none
  std::uint64_t hash = 0;
  std::uint64_t requests = 0;
  std::uint64_t enabled_ticks = 0;
  std::uint64_t faults = 0;
  std::uint64_t emergencies = 0;
  std::uint64_t time_outs = 0;
  std::uint32_t modes = 0;  ///< active in Operation enabled, bits as in 6502h

  void add(const MasterReport& other) {
    modes |= other.modes;
    requests += other.requests;
    enabled_ticks += other.enabled_ticks;
    faults += other.faults;
    emergencies += other.emergencies;
    time_outs += other.time_outs;
  }
};

/// One seed.
class MasterSimulation {
 public:
  explicit MasterSimulation(std::uint64_t seed) : random_(seed) {
    node_.start({.status = drive_.status()}, now_);
    observe(node_.state());
  }

  MasterReport play() {
    for (std::uint64_t tick = 0; tick < kTicksOfASeed && report_.broken.empty(); ++tick) {
      play_tick();
      note(tick);
    }
    while (complete()) {
    }
    verdict_.demand(outstanding_ == 0, "every SDO request is answered or aborted");
    note(kTicksOfASeed);
    report_.time_outs = node_.counters().sdo_time_outs;
    return report_;
  }

 private:
  void play_tick() {
    for (std::uint64_t frames = random_.below(4); frames > 0; --frames) {
      receive(master_.next());
      if (random_.one_in(2)) complete();
    }
    if (!random_.one_in(4)) complete();
    if (random_.one_in(100)) drive_.is_owned = !drive_.is_owned;
    const std::uint32_t faults = drive_.status().fault_count;
    const DriveView view = drive_.step();
    report_.faults += view.status.fault_count > faults ? 1U : 0U;
    note_mode(view.status);
    now_ += kTick;
    const NmtState before = node_.state();
    node_.update(view, now_);
    observe(before);
    // A late bench may skip a call of advance(); the next call makes up for it.
    if (random_.one_in(10)) return;
    const NmtState before_advance = node_.state();
    node_.advance(now_);
    observe(before_advance);
    const auto due = node_.next_due();
    verdict_.demand(!due || *due > now_, "advance() does all that is due");
  }

  void note_mode(const AxisStatus& status) {
    if (drive_.state() != PowerState::operation_enabled) return;
    ++report_.enabled_ticks;
    const auto mode = static_cast<unsigned>(status.op_mode_actual);
    if (mode != 0) report_.modes |= 1U << (mode - 1U);
  }

  void receive(const Frame& frame) {
    const NmtState before = node_.state();
    const bool is_served = before != NmtState::stopped && !frame.is_extended && !frame.is_remote &&
                           frame.id == kRequestId && frame.size == kMostData;
    const bool is_abort = frame.data[0] >> 5U == 4;
    if (is_served && !is_abort) {
      ++outstanding_;
      ++report_.requests;
    }
    node_.receive(frame, now_);
    observe(before);
    if (is_served && is_abort) outstanding_ = 0;
  }

  bool complete() {
    const auto answer = drive_.answer_access();
    if (!answer) return false;
    const NmtState before = node_.state();
    node_.complete(answer->first, answer->second, now_);
    observe(before);
    return true;
  }

  /// Checks the frames that the node has sent in a call that found it in state `before`.
  void observe(NmtState before) {
    const bool stays_stopped = before == NmtState::stopped && node_.state() == before;
    for (const Frame& frame : drive_.take()) {
      hash_in(frame);
      verdict_.demand(!frame.is_extended && !frame.is_remote && frame.size <= kMostData,
                      "a node sends data frames of the base format");
      verdict_.demand(!stays_stopped || frame.id == kNodeHeartbeatId,
                      "a stopped node sends its heartbeat, only");
      if (frame.id == kResponseId) {
        --outstanding_;
        verdict_.demand(frame.size == kMostData, "an SDO response has 8 bytes");
      } else if (frame.id == kNodeHeartbeatId) {
        verdict_.demand(frame.size == 1, "a heartbeat has one byte");
        if (frame.data[0] == 0) outstanding_ = 0;  // boot-up: the reset dropped all requests
      } else if (frame.id == 0x080U + kSimulatedNode) {
        ++report_.emergencies;
      }
    }
    // A time-out sends an abort without a request.
    const std::uint64_t time_outs = node_.counters().sdo_time_outs;
    outstanding_ += static_cast<std::int64_t>(time_outs - time_outs_);
    time_outs_ = time_outs;
    if (node_.state() == NmtState::stopped) outstanding_ = 0;
    verdict_.demand(outstanding_ >= 0, "no SDO request is answered twice");
    verdict_.demand(outstanding_ <= kMostOutstanding, "what may wait is bounded");
  }

  void hash_in(const Frame& frame) {
    std::uint64_t bytes = frame.id;
    for (const std::uint8_t byte : frame.bytes()) bytes = bytes * 257 + byte;
    report_.hash = (report_.hash ^ bytes) * 0x9E3779B97F4A7C15U;
  }

  void note(std::uint64_t tick) {
    if (!report_.broken.empty() || verdict_.broken().empty()) return;
    report_.broken = "tick " + std::to_string(tick) + ": violated: " + verdict_.broken();
  }

  Random random_;
  Verdict verdict_;
  SimulatedDrive drive_{verdict_};
  Node node_{{.node_id = kSimulatedNode}, drive_};
  RandomMaster master_{drive_, random_};
  DriveTime now_{};
  std::int64_t outstanding_ = 0;  ///< unanswered SDO requests
  std::uint64_t time_outs_ = 0;
  MasterReport report_;
};

MasterReport play_seed(std::uint64_t seed) {
  return MasterSimulation(seed).play();
}

TEST(MasterSimulation, KeepsEveryInvariantAndAnswersEverySdoRequestInEverySeed) {
  const char* const alone = std::getenv("VDRIVE_MASTER_SEED");
  const std::uint64_t first = alone == nullptr ? 1 : std::stoull(alone);
  const std::uint64_t last =
      alone == nullptr
          ? test::number_of<std::uint64_t>({.usual = 100, .full = 1'000, .nightly = 10'000})
          : first;
  MasterReport sum;
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    const MasterReport report = play_seed(seed);
    ASSERT_EQ(report.broken, "") << "seed " << seed << "; again: VDRIVE_MASTER_SEED=" << seed;
    sum.add(report);
  }
  if (alone != nullptr) return;
  // The test is not vacuous: every kind of event has occurred.
  const std::uint64_t seeds = last - first + 1;
  EXPECT_GT(sum.requests, 100 * seeds);
  EXPECT_GT(sum.enabled_ticks, seeds);
  EXPECT_GT(sum.faults, 0U);
  EXPECT_GT(sum.emergencies, seeds / 10);
  EXPECT_EQ(sum.modes, kSupportedDriveModes);
}

TEST(MasterSimulation, GivesTheSameFramesForTheSameSeed) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_EQ(play_seed(seed).hash, play_seed(seed).hash) << "seed " << seed;
  }
  EXPECT_NE(play_seed(1).hash, play_seed(2).hash);
}

}  // namespace
}  // namespace vdrive::canopen
