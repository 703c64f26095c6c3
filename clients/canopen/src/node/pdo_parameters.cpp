// SPDX-License-Identifier: Apache-2.0
#include "node/pdo_parameters.hpp"

#include "node/node_object.hpp"

#include <chrono>
#include <ratio>

namespace vdrive::canopen {
namespace {

constexpr std::uint16_t kFirstReceiveParameter = 0x1400;
constexpr std::uint16_t kFirstTransmitParameter = 0x1800;
constexpr std::uint16_t kMappingOffset = 0x0200;  // 1400h to 1600h, 1800h to 1A00h

constexpr std::uint8_t kCobIdSub = 1;
constexpr std::uint8_t kTypeSub = 2;
constexpr std::uint8_t kInhibitTimeSub = 3;
constexpr std::uint8_t kEventTimerSub = 5;  // 4 is reserved
constexpr std::uint8_t kSyncStartSub = 6;

constexpr std::uint32_t kLongestTimer = 0xFFFF;
constexpr std::uint32_t kHighestSyncCounter = 240;

using HundredMicroseconds = std::chrono::duration<std::int64_t, std::ratio<1, 10'000>>;

std::uint16_t parameter_index(PdoDirection direction, std::uint8_t number) {
  const unsigned first =
      direction == PdoDirection::receive ? kFirstReceiveParameter : kFirstTransmitParameter;
  return static_cast<std::uint16_t>(first + number - 1U);
}

bool is_transmission_type(std::uint32_t type, PdoDirection direction) {
  if (type <= kLastSynchronous) return true;
  const std::uint32_t first =
      direction == PdoDirection::transmit ? kRemoteSynchronous : kFirstEventDriven;
  return type >= first && type <= 0xFF;
}

}  // namespace

PdoParameters::PdoParameters(PdoDirection direction, PdoPlace place)
    : direction_(direction),
      index_(parameter_index(direction, place.number)),
      node_id_(place.node_id),
      mapping_(static_cast<std::uint16_t>(index_ + kMappingOffset), direction) {
  reset();
}

void PdoParameters::reset() {
  const auto initial = [this](std::uint8_t subindex) {
    return initial_value({index_, subindex}, node_id_);
  };
  mapping_.reset();
  cob_id_ = initial(kCobIdSub);
  type_ = static_cast<std::uint8_t>(initial(kTypeSub));
  inhibit_ = static_cast<std::uint16_t>(initial(kInhibitTimeSub));
  event_timer_ = static_cast<std::uint16_t>(initial(kEventTimerSub));
  sync_start_ = static_cast<std::uint8_t>(initial(kSyncStartSub));
}

std::uint32_t PdoParameters::read(ObjectAddress object) const {
  return is_mapping(object) ? mapping_.read(object.subindex) : read_communication(object.subindex);
}

AbortCode PdoParameters::write(ObjectAddress object, std::uint32_t value) {
  return is_mapping(object) ? mapping_.write(object.subindex, value, is_valid())
                            : write_communication(object.subindex, value);
}

DriveTime PdoParameters::inhibit_time() const noexcept {
  return HundredMicroseconds(inhibit_);
}

DriveTime PdoParameters::event_time() const noexcept {
  return std::chrono::milliseconds(event_timer_);
}

bool PdoParameters::is_mapping(ObjectAddress object) const noexcept {
  return object.index != index_;
}

std::uint32_t PdoParameters::read_communication(std::uint8_t subindex) const {
  switch (subindex) {
    case kCobIdSub:
      return cob_id_;
    case kTypeSub:
      return type_;
    case kInhibitTimeSub:
      return inhibit_;
    case kEventTimerSub:
      return event_timer_;
    case kSyncStartSub:
      return sync_start_;
    default:
      return initial_value({index_, subindex});
  }
}

AbortCode PdoParameters::write_communication(std::uint8_t subindex, std::uint32_t value) {
  switch (subindex) {
    case 0:
      return AbortCode::write_of_read_only_object;
    case kCobIdSub:
      return write_cob_id(value);
    case kTypeSub:
      return write_type(value);
    case kInhibitTimeSub:
      return write_inhibit_time(value);
    case kEventTimerSub:
      return write_event_timer(value);
    case kSyncStartSub:
      return write_sync_start(value);
    default:
      return AbortCode::subindex_does_not_exist;
  }
}

AbortCode PdoParameters::write_cob_id(std::uint32_t value) {
  if ((value & kCobIdExtendedBits) != 0) return AbortCode::value_range_exceeded;
  if ((value & kCobIdNotValid) == 0) {
    const bool changes_can_id = is_valid() && can_id_of(value) != can_id();
    // Masters disable a PDO with any CAN-ID, often 0: the CAN-ID matters only while the PDO is
    // valid.
    if (changes_can_id || is_restricted_can_id(can_id_of(value)) || mapping_.size() == 0) {
      return AbortCode::value_range_exceeded;
    }
  }
  cob_id_ = value;
  return AbortCode::none;
}

AbortCode PdoParameters::write_type(std::uint32_t value) {
  if (!is_transmission_type(value, direction_)) return AbortCode::value_range_exceeded;
  type_ = static_cast<std::uint8_t>(value);
  return AbortCode::none;
}

AbortCode PdoParameters::write_inhibit_time(std::uint32_t value) {
  const bool is_changed = value != inhibit_;
  if (value > kLongestTimer || (is_changed && is_valid())) return AbortCode::value_range_exceeded;
  inhibit_ = static_cast<std::uint16_t>(value);
  return AbortCode::none;
}

AbortCode PdoParameters::write_event_timer(std::uint32_t value) {
  if (value > kLongestTimer) return AbortCode::value_range_exceeded;
  event_timer_ = static_cast<std::uint16_t>(value);
  return AbortCode::none;
}

AbortCode PdoParameters::write_sync_start(std::uint32_t value) {
  const bool is_changed = value != sync_start_;
  if (value > kHighestSyncCounter || (is_changed && is_valid())) {
    return AbortCode::value_range_exceeded;
  }
  sync_start_ = static_cast<std::uint8_t>(value);
  return AbortCode::none;
}

}  // namespace vdrive::canopen
