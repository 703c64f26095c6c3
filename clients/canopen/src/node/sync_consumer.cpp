// SPDX-License-Identifier: Apache-2.0
#include "node/sync_consumer.hpp"

#include "node/cob_id.hpp"
#include "node/node_object.hpp"

namespace vdrive::canopen {
namespace {

constexpr std::uint16_t kSyncCobId = 0x1005;
constexpr std::uint16_t kCyclePeriod = 0x1006;
constexpr std::uint16_t kWindowLength = 0x1007;
constexpr std::uint16_t kCounterOverflow = 0x1019;

constexpr std::uint32_t kLowestOverflow = 2;
constexpr std::uint32_t kHighestOverflow = 240;

AbortCode check_sync_cob_id(std::uint32_t value) {
  const bool is_refused = (value & (kCobIdExtendedBits | kCobIdProducer)) != 0 ||
                          is_restricted_can_id(can_id_of(value));
  return is_refused ? AbortCode::value_range_exceeded : AbortCode::none;
}

}  // namespace

SyncConsumer::SyncConsumer(std::optional<std::uint32_t> period) : stepped_period_(period) {
  reset();
}

bool SyncConsumer::has(ObjectAddress object) noexcept {
  if (object.subindex != 0) return false;
  switch (object.index) {
    case kSyncCobId:
    case kCyclePeriod:
    case kWindowLength:
    case kCounterOverflow:
      return true;
    default:
      return false;
  }
}

void SyncConsumer::reset() {
  cob_id_ = initial_value({kSyncCobId, 0});
  period_ = initial_value({kCyclePeriod, 0});
  window_ = initial_value({kWindowLength, 0});
  overflow_ = initial_value({kCounterOverflow, 0});
  restart();
}

void SyncConsumer::restart() {
  received_.reset();
  has_wrong_length_ = false;
}

std::uint32_t SyncConsumer::read(ObjectAddress object) const noexcept {
  switch (object.index) {
    case kSyncCobId:
      return cob_id_;
    case kCyclePeriod:
      return period_;
    case kWindowLength:
      return window_;
    case kCounterOverflow:
      return overflow_;
    default:
      return 0;
  }
}

AbortCode SyncConsumer::write(ObjectAddress object, std::uint32_t value) {
  const AbortCode refusal = check(object.index, value);
  if (refusal != AbortCode::none) return refusal;
  switch (object.index) {
    case kSyncCobId:
      cob_id_ = value;
      break;
    case kCyclePeriod:
      period_ = value;
      break;
    case kWindowLength:
      window_ = value;
      break;
    default:
      overflow_ = value;
      break;
  }
  return AbortCode::none;
}

bool SyncConsumer::is_sync(const Frame& frame) const noexcept {
  return !frame.is_extended && !frame.is_remote && frame.id == can_id_of(cob_id_);
}

SyncReception SyncConsumer::receive(const Frame& frame, DriveTime now) {
  const bool has_counter = overflow_ != 0;
  const bool is_wrong = frame.size != (has_counter ? 1U : 0U);
  const bool is_news = is_wrong && !has_wrong_length_;
  has_wrong_length_ = is_wrong;
  if (is_wrong) return {.error_code = is_news ? kSyncLength : std::uint16_t{0}};
  received_ = now;
  return {.is_used = true, .counter = has_counter ? frame.data[0] : std::uint8_t{0}};
}

bool SyncConsumer::is_window_over(DriveTime now) const noexcept {
  return window_ != 0 && received_ && now - *received_ > DriveTime(window_);
}

AbortCode SyncConsumer::check(std::uint16_t index, std::uint32_t value) const {
  switch (index) {
    case kSyncCobId:
      return check_sync_cob_id(value);
    case kCyclePeriod:
      return value == 0 || value == stepped_period_.value_or(value)
                 ? AbortCode::none
                 : AbortCode::value_range_exceeded;
    case kCounterOverflow:
      return check_overflow(value);
    default:
      return AbortCode::none;
  }
}

AbortCode SyncConsumer::check_overflow(std::uint32_t value) const {
  const bool is_overflow = value == 0 || (value >= kLowestOverflow && value <= kHighestOverflow);
  if (!is_overflow) return AbortCode::value_range_exceeded;
  if (value != overflow_ && period_ != 0) return AbortCode::refused_in_present_device_state;
  return AbortCode::none;
}

}  // namespace vdrive::canopen
