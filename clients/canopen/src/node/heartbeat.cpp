// SPDX-License-Identifier: Apache-2.0
#include "node/heartbeat.hpp"

#include "node/cob_id.hpp"
#include "node/node_object.hpp"
#include "node/node_settings.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <chrono>

namespace vdrive::canopen {
namespace {

constexpr std::uint16_t kConsumerTime = 0x1016;
constexpr std::uint16_t kProducerTime = 0x1017;

constexpr std::uint32_t kReservedOfEntry = 0xFF000000;

}  // namespace

HeartbeatProducer::HeartbeatProducer(std::uint8_t node_id, NodeHost& host)
    : node_id_(node_id), host_(host) {
  reset();
}

void HeartbeatProducer::set_time(std::uint16_t milliseconds, DriveTime now) {
  time_ = milliseconds;
  next_ = milliseconds == 0 ? std::nullopt : std::optional(now);
}

void HeartbeatProducer::reset() {
  time_ = static_cast<std::uint16_t>(initial_value({kProducerTime, 0}));
  next_.reset();
}

void HeartbeatProducer::boot_up(DriveTime now) {
  send(NmtState::boot_up);
  next_ = time_ == 0 ? std::nullopt : std::optional(now + period());
}

void HeartbeatProducer::advance(NmtState state, DriveTime now) {
  if (!next_ || now < *next_) return;
  send(state);
  *next_ += period();
  if (*next_ <= now) next_ = now + period();
}

DriveTime HeartbeatProducer::period() const noexcept {
  return std::chrono::milliseconds{time_};
}

void HeartbeatProducer::send(NmtState state) {
  Frame frame{.id = kHeartbeatId + node_id_, .size = 1};
  frame.data[0] = static_cast<std::uint8_t>(state);
  host_.send(frame);
}

HeartbeatConsumer::HeartbeatConsumer() {
  reset();
}

std::uint32_t HeartbeatConsumer::entry(std::uint8_t subindex) const {
  ensure(subindex >= 1 && subindex <= kEntries, "1016h has this sub-index");
  return entries_[subindex - 1U].value;
}

AbortCode HeartbeatConsumer::set_entry(std::uint8_t subindex, std::uint32_t value) {
  ensure(subindex >= 1 && subindex <= kEntries, "1016h has this sub-index");
  if ((value & kReservedOfEntry) != 0) return AbortCode::value_range_exceeded;
  Entry& written = entries_[subindex - 1U];
  const Entry wanted{.value = value};
  const bool is_watched = std::ranges::any_of(entries_, [&](const Entry& other) {
    return &other != &written && other.is_used() && other.producer() == wanted.producer();
  });
  if (wanted.is_used() && is_watched) return AbortCode::parameter_incompatibility;
  written = wanted;
  return AbortCode::none;
}

void HeartbeatConsumer::reset() {
  std::uint8_t subindex = 0;
  for (Entry& entry : entries_) {
    ++subindex;
    entry = {.value = initial_value({kConsumerTime, subindex})};
  }
}

void HeartbeatConsumer::receive(std::uint8_t producer, DriveTime now) {
  for (Entry& entry : entries_) {
    if (!entry.is_used() || entry.producer() != producer) continue;
    entry.deadline = now + entry.time();
    entry.is_silent = false;
  }
}

std::optional<std::uint8_t> HeartbeatConsumer::take_silent(DriveTime now) {
  for (Entry& entry : entries_) {
    if (!entry.deadline || now < *entry.deadline) continue;
    entry.deadline.reset();
    entry.is_silent = true;
    return entry.producer();
  }
  return std::nullopt;
}

bool HeartbeatConsumer::has_silent() const {
  return std::ranges::any_of(entries_, &Entry::is_silent);
}

std::optional<DriveTime> HeartbeatConsumer::next_due() const {
  std::optional<DriveTime> due;
  for (const Entry& entry : entries_) {
    if (entry.deadline && (!due || *entry.deadline < *due)) due = entry.deadline;
  }
  return due;
}

std::uint8_t HeartbeatConsumer::Entry::producer() const noexcept {
  return static_cast<std::uint8_t>(value >> 16U & 0xFFU);
}

DriveTime HeartbeatConsumer::Entry::time() const noexcept {
  return std::chrono::milliseconds{value & 0xFFFFU};
}

bool HeartbeatConsumer::Entry::is_used() const noexcept {
  return producer() >= kLowestNodeId && producer() <= kHighestNodeId && time() > DriveTime::zero();
}

}  // namespace vdrive::canopen
