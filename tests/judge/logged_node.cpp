// SPDX-License-Identifier: Apache-2.0
#include "judge/logged_node.hpp"

#include "judge/axis_track.hpp"
#include "node/cob_id.hpp"
#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/cia402/statusword.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace vdrive::judge {
namespace {

using canopen::Frame;
using namespace std::chrono_literals;

constexpr std::chrono::microseconds kTick{1000};
constexpr std::chrono::microseconds kFrameTime{100};
constexpr std::uint32_t kFirstTransmitPdo = 0x180;
constexpr std::uint32_t kPdoDistance = 0x100;

Frame frame_with(std::uint32_t id, std::span<const std::uint8_t> bytes) {
  Frame frame;
  frame.id = id;
  frame.size = static_cast<std::uint8_t>(bytes.size());
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}

std::string line_of(const Frame& frame, std::chrono::microseconds time) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "(%010lld.%06lld) can0 %03X#",
                static_cast<long long>(time.count() / 1'000'000),
                static_cast<long long>(time.count() % 1'000'000), frame.id);
  std::string line = text.data();
  for (const std::uint8_t byte : frame.bytes()) {
    std::snprintf(text.data(), text.size(), "%02X", byte);
    line += text.data();
  }
  return line + "\n";
}

}  // namespace

LoggedNode::LoggedNode() : axis_({}, kTick) {
  axis_.step();
  canopen::NodeHost& host = *this;
  node_.emplace(canopen::NodeSettings{.node_id = kNode}, host);
  node_->start(view(), now_);
}

canopen::DriveView LoggedNode::view() const {
  return {.status = axis_.status()};
}

void LoggedNode::put(const Frame& frame) {
  frame_time_ = std::max(frame_time_ + kFrameTime, now_);
  log_ += line_of(frame, frame_time_);
  frames_.push_back(frame);
}

/// Sends a frame of the node.
void LoggedNode::send(const Frame& frame) {
  put(frame);
  if (frame.id == canopen::kSdoResponseId + kNode) sdo_answer_ = frame;
  const bool is_pdo = frame.id >= kFirstTransmitPdo &&
                      (frame.id - kFirstTransmitPdo) % kPdoDistance == kNode &&
                      frame.id < 0x500 + kNode;
  if (is_pdo && frame.size >= 2) {
    statusword_ = static_cast<std::uint16_t>(frame.data[0] | frame.data[1] << 8U);
  }
}

void LoggedNode::command(std::span<const canopen::DriveValue> values) {
  for (const bool is_word : {false, true}) {
    for (const canopen::DriveValue& value : values) {
      if ((value.object == objects::kControlword) == is_word)
        axis_.write(value.object, value.value);
    }
  }
}

void LoggedNode::set_connection_lost(bool is_lost) {
  if (is_lost) axis_.report_connection_loss();
}

void LoggedNode::answer() {
  while (access_) {
    const canopen::DriveAccess access = *std::exchange(access_, std::nullopt);
    canopen::DriveAnswer answer;
    if (access.value) {
      answer.abort = axis_.write(access.object, *access.value);
    } else {
      const ReadResult result = axis_.read(access.object);
      answer = {.abort = result.code, .value = result.value};
    }
    node_->complete(access.ticket, answer, now_);
  }
}

void LoggedNode::put_on_bus(const Frame& frame) {
  put(frame);
  node_->receive(frame, now_);
  answer();
}

void LoggedNode::put_on_bus(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  put_on_bus(frame_with(id, std::span(bytes.begin(), bytes.size())));
}

void LoggedNode::nmt(std::uint8_t command, std::uint8_t node) {
  put_on_bus(canopen::kNmtId, {command, node});
}

void LoggedNode::sync() {
  put_on_bus(canopen::kSyncId, {});
}

std::uint32_t LoggedNode::write(ObjectAddress object, std::int64_t value, std::size_t size) {
  Frame frame = frame_with(canopen::kSdoRequestId + kNode, std::array<std::uint8_t, 8>{});
  frame.data[0] = static_cast<std::uint8_t>(0x23U | (4U - size) << 2U);
  canopen::put_little_endian(object.index, std::span(frame.data).subspan(1, 2));
  frame.data[3] = object.subindex;
  canopen::put_little_endian(static_cast<std::uint64_t>(value),
                             std::span(frame.data).subspan(4, size));
  sdo_answer_.reset();
  put_on_bus(frame);
  if (!sdo_answer_) throw std::logic_error("the node did not answer");
  if (sdo_answer_->data[0] != 0x80) return 0;
  return static_cast<std::uint32_t>(
      canopen::little_endian_number(std::span(sdo_answer_->data).subspan(4)));
}

std::int64_t LoggedNode::read(ObjectAddress object) {
  Frame frame = frame_with(canopen::kSdoRequestId + kNode, std::array<std::uint8_t, 8>{0x40});
  canopen::put_little_endian(object.index, std::span(frame.data).subspan(1, 2));
  frame.data[3] = object.subindex;
  sdo_answer_.reset();
  put_on_bus(frame);
  if (!sdo_answer_ || sdo_answer_->data[0] == 0x80) throw std::logic_error("not read");
  return canopen::signed_little_endian_number(std::span(sdo_answer_->data).subspan(4));
}

void LoggedNode::pdo(std::uint16_t number,
                     std::initializer_list<std::pair<std::int64_t, std::size_t>> values) {
  Frame frame;
  frame.id = 0x100U + kPdoDistance * number + kNode;
  for (const auto& [value, size] : values) {
    canopen::put_little_endian(static_cast<std::uint64_t>(value),
                               std::span(frame.data).subspan(frame.size, size));
    frame.size = static_cast<std::uint8_t>(frame.size + size);
  }
  put_on_bus(frame);
}

void LoggedNode::map(std::uint16_t number, std::initializer_list<std::uint32_t> entries,
                     std::uint8_t type) {
  const auto offset = static_cast<std::uint16_t>(number - 1);
  const auto communication = static_cast<std::uint16_t>(0x1400 + offset);
  const auto mapping = static_cast<std::uint16_t>(0x1600 + offset);
  const std::uint32_t id = 0x100U + kPdoDistance * number + kNode;
  write({communication, 1}, canopen::kCobIdNotValid | id, 4);
  write({mapping, 0}, 0, 1);
  std::uint8_t subindex = 0;
  for (const std::uint32_t entry : entries) write({mapping, ++subindex}, entry, 4);
  write({mapping, 0}, subindex, 1);
  write({communication, 2}, type, 1);
  write({communication, 1}, id, 4);
}

void LoggedNode::step(std::uint64_t ticks) {
  for (std::uint64_t i = 0; i < ticks; ++i) {
    axis_.step();
    now_ += kTick;
    node_->update(view(), now_);
    node_->advance(now_);
    answer();
  }
}

bool LoggedNode::step_until(const std::function<bool()>& done, std::uint64_t deadline) {
  for (std::uint64_t i = 0; i < deadline; ++i) {
    step();
    if (done()) return true;
  }
  return false;
}

bool LoggedNode::step_until_state(PowerState state) {
  return step_until([this, state] {
    return decode_power_state(statusword_) == state;
  });
}

bool LoggedNode::step_until_bits(std::uint16_t mask, std::uint16_t value) {
  return step_until([this, mask, value] {
    return (statusword_ & mask) == value;
  });
}

void LoggedNode::enable(std::int8_t mode) {
  nmt(0x01);
  step(2);
  pdo(2, {{0, 2}, {mode, 1}});
  step_until([this, mode] {
    return axis_.status().op_mode_actual == mode;
  });
  step(2);
  word(controlwords::kShutdown);
  step_until_state(PowerState::ready_to_switch_on);
  word(controlwords::kSwitchOn);
  step_until_state(PowerState::switched_on);
  word(controlwords::kEnableOperation);
  step_until_state(PowerState::operation_enabled);
}

void LoggedNode::move(std::int32_t target) {
  pdo(3, {{controlwords::kEnableOperation, 2}, {target, 4}});
  step(2);
  word(controlwords::kEnableOperation | Controlword::kNewSetPoint);
  step_until_bits(Statusword::kSetPointAcknowledge, Statusword::kSetPointAcknowledge);
  word(controlwords::kEnableOperation);
  step_until_bits(Statusword::kSetPointAcknowledge, 0);
  step_until_bits(Statusword::kTargetReached, Statusword::kTargetReached);
}

void LoggedNode::disable() {
  word(controlwords::kShutdown);
  step_until_state(PowerState::ready_to_switch_on);
}

}  // namespace vdrive::judge
