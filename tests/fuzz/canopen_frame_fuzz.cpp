// SPDX-License-Identifier: Apache-2.0
//
// Any frames at any time for a CANopen node: it sends valid frames, answers each SDO request once
// (within a block transfer, each block of segments), and gives the drive set-points in the order
// that the drive needs.
#include "fuzz/support/bytes.hpp"
#include "node/node.hpp"
#include "node/node_object.hpp"
#include "node/sdo_block.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <utility>

namespace {

using namespace vdrive::canopen;
using vdrive::AbortCode;
using vdrive::ObjectAddress;
using vdrive::test::Bytes;
using vdrive::test::demand;

constexpr std::uint8_t kNodeId = 3;
constexpr std::uint32_t kSdoRequest = 0x600 + kNodeId;
constexpr std::uint32_t kSdoAnswer = 0x580 + kNodeId;
constexpr std::uint32_t kSpecifier = 0xE0;
constexpr std::uint32_t kAbortTransfer = 0x80;
constexpr std::uint32_t kBlockUpload = 0xA0;
constexpr std::uint32_t kBlockDownload = 0xC0;
constexpr ObjectAddress kControlword{.index = 0x6040, .subindex = 0};

class FuzzedHost final : public NodeHost {
 public:
  void send(const Frame& frame) override {
    demand(frame.size <= kMostData && frame.id <= kHighestBaseId && !frame.is_extended &&
               !frame.is_remote,
           "a node sends data frames in the base format");
    if (frame.id == kSdoAnswer) {
      demand(frame.size == kMostData, "an SDO answer has 8 bytes");
      ++sdo_answers;
    }
  }

  void begin_access(const DriveAccess& begun) override {
    demand(!access, "one access of the drive at a time");
    const NodeObject* const object = find_node_object(begun.object);
    demand(object != nullptr && object->owner == ObjectOwner::drive,
           "the drive is asked for its own objects");
    access = begun;
  }

  void command(std::span<const DriveValue> values) override {
    std::set<ObjectAddress> objects;
    for (const DriveValue& value : values) {
      demand(objects.insert(value.object).second, "each object has one set-point");
    }
    const auto controlword = std::ranges::find(values, kControlword, &DriveValue::object);
    demand(controlword == values.end() || controlword + 1 == values.end(),
           "the controlword acts last");
  }

  void set_connection_lost(bool /*is_lost*/) override {}

  void power_cycle() override {}

  bool store(const std::map<ObjectAddress, std::uint32_t>& /*parameters*/) override { return true; }

  std::optional<DriveAccess> access;
  std::uint64_t sdo_answers = 0;
};

class FuzzedNode {
 public:
  explicit FuzzedNode(Bytes& bytes) : bytes_(bytes), node_({.node_id = kNodeId}, host_) {
    node_.start(drive_, now_);
  }

  void act() {
    switch (bytes_.below(8)) {
      case 0:
        return receive(any_frame());
      case 1:
        return receive(nmt_frame());
      case 2:
        return receive(sync_frame());
      case 3:
        return receive(pdo_frame());
      case 4:
        return advance_time();
      case 5:
        return change_drive();
      default:
        return receive(sdo_frame());
    }
  }

 private:
  void fill(Frame& frame, std::size_t from) {
    for (std::size_t i = from; i < frame.size; ++i) frame.data.at(i) = bytes_.take();
  }

  Frame any_frame() {
    Frame frame;
    const std::size_t kind = bytes_.below(8);
    frame.is_extended = kind == 0;
    frame.is_remote = kind < 3;
    frame.id =
        bytes_.take<std::uint32_t>() & (frame.is_extended ? kHighestExtendedId : kHighestBaseId);
    frame.size = static_cast<std::uint8_t>(bytes_.below(kMostData + 1));
    if (!frame.is_remote) fill(frame, 0);
    return frame;
  }

  Frame nmt_frame() {
    constexpr std::array<std::uint8_t, 5> kSpecifiers{0x01, 0x02, 0x80, 0x81, 0x82};
    Frame frame{.id = 0, .size = 2};
    frame.data[0] = kSpecifiers.at(bytes_.below(kSpecifiers.size()));
    frame.data[1] = bytes_.below(4) == 0 ? bytes_.take() : kNodeId;
    return frame;
  }

  Frame sync_frame() {
    Frame frame{.id = 0x080, .size = static_cast<std::uint8_t>(bytes_.below(3))};
    fill(frame, 0);
    return frame;
  }

  /// Of this node or a neighbour: RPDOs, heartbeats and emergencies.
  Frame pdo_frame() {
    const auto function = static_cast<std::uint32_t>(bytes_.below(16)) << 7U;
    const auto node = static_cast<std::uint32_t>(bytes_.below(2));
    Frame frame{.id = function + kNodeId + node,
                .size = static_cast<std::uint8_t>(bytes_.below(kMostData + 1))};
    fill(frame, 0);
    return frame;
  }

  /// Mostly to an object that exists.
  Frame sdo_frame() {
    Frame frame{.id = kSdoRequest, .size = kMostData};
    frame.data[0] = bytes_.take();
    ObjectAddress object{.index = bytes_.take<std::uint16_t>(), .subindex = bytes_.take()};
    if (bytes_.below(8) != 0) {
      const auto objects = node_objects();
      object = objects[object.index % objects.size()].address;
    }
    frame.data[1] = static_cast<std::uint8_t>(object.index & 0xFFU);
    frame.data[2] = static_cast<std::uint8_t>(object.index >> 8U);
    frame.data[3] = object.subindex;
    fill(frame, 4);
    return frame;
  }

  void receive(const Frame& frame) {
    const std::uint64_t before = host_.sdo_answers;
    const bool is_request = frame.id == kSdoRequest && !frame.is_extended && !frame.is_remote &&
                            frame.size == kMostData &&
                            (frame.data[0] & kSpecifier) != kAbortTransfer;
    const bool is_served =
        node_.state() == NmtState::pre_operational || node_.state() == NmtState::operational;
    node_.receive(frame, now_);
    while (host_.access) complete();
    const std::uint64_t answers = host_.sdo_answers - before;
    note_block(frame);
    if (has_block_) {
      demand(answers <= kMostSegments, "a block has a bounded number of segments");
    } else {
      demand(answers == (is_request && is_served ? 1U : 0U), "each SDO request has one answer");
    }
    check_state();
  }

  /// From the first request of a block transfer to an abort by the client.
  void note_block(const Frame& frame) {
    if (frame.id != kSdoRequest || frame.is_extended || frame.is_remote) return;
    if (frame.size != kMostData) return;
    const std::uint32_t specifier = frame.data[0] & kSpecifier;
    has_block_ = frame.data[0] != kAbortTransfer &&
                 (has_block_ || specifier == kBlockUpload || specifier == kBlockDownload);
  }

  void complete() {
    const DriveAccess access = *std::exchange(host_.access, std::nullopt);
    const NodeObject* const object = find_node_object(access.object);
    constexpr std::array kAborts{AbortCode::none, AbortCode::none, AbortCode::value_range_exceeded,
                                 AbortCode::refused_local_control};
    const AbortCode abort = kAborts.at(bytes_.below(kAborts.size()));
    // A ticket of another access is ignored.
    node_.complete(access.ticket + 1, {.abort = AbortCode::none, .value = 0}, now_);
    node_.complete(access.ticket, {.abort = abort, .value = object->default_value}, now_);
  }

  void advance_time() {
    now_ += std::chrono::microseconds(bytes_.take<std::uint16_t>());
    const auto due = node_.next_due();
    if (due && *due < now_ && bytes_.below(2) == 0) node_.advance(*due);
    node_.advance(now_);
    const auto next = node_.next_due();
    demand(!next || *next > now_, "what was due is done");
  }

  void change_drive() {
    drive_.status.ds402_statusword = bytes_.take<std::uint16_t>();
    drive_.status.load_position_actual_value = bytes_.take<std::int16_t>();
    drive_.status.error_code = bytes_.below(4) == 0 ? bytes_.take<std::uint16_t>() : 0;
    drive_.is_owned = bytes_.below(4) != 0;
    node_.update(drive_, now_);
    check_state();
  }

  void check_state() const {
    const NmtState state = node_.state();
    demand(state == NmtState::pre_operational || state == NmtState::operational ||
               state == NmtState::stopped || state == NmtState::boot_up,
           "a node has a state");
    demand(node_.id() == kNodeId, "and keeps its id");
  }

  Bytes& bytes_;
  FuzzedHost host_;
  DriveTime now_{};
  DriveView drive_{};
  bool has_block_ = false;
  Node node_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes({data, size});
  FuzzedNode node(bytes);
  while (!bytes.empty()) node.act();
  return 0;
}
