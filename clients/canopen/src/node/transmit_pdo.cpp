// SPDX-License-Identifier: Apache-2.0
#include "node/transmit_pdo.hpp"

#include "node/frame.hpp"

#include <algorithm>
#include <cstddef>
#include <span>

namespace vdrive::canopen {

TransmitPdo::TransmitPdo(PdoPlace place) : parameters_(PdoDirection::transmit, place) {}

void TransmitPdo::reset() {
  parameters_.reset();
  forget_values();
  restart();
}

void TransmitPdo::restart() {
  sent_.reset();
  sent_at_ = {};
  sample_.reset();
  sync_count_ = 0;
  awaits_sync_start_ = true;
  is_requested_ = false;
  is_waiting_ = false;
}

AbortCode TransmitPdo::write(ObjectAddress object, std::uint32_t value) {
  const bool was_valid = parameters_.is_valid();
  const std::uint8_t type = parameters_.type();
  const AbortCode refusal = parameters_.write(object, value);
  if (was_valid != parameters_.is_valid() || type != parameters_.type()) restart();
  // The mapping can change only while the PDO is not valid.
  if (was_valid != parameters_.is_valid()) forget_values();
  return refusal;
}

// ---- values that must be read ----------------------------------------------------------------

void TransmitPdo::add_read_objects(std::vector<ObjectAddress>& objects) const {
  if (!parameters_.is_valid()) return;
  for (const MappedObject& object : parameters_.mapping().objects()) {
    const bool is_known = std::ranges::find(objects, object.address) != objects.end();
    if (object.member == nullptr && !is_known) objects.push_back(object.address);
  }
}

void TransmitPdo::set_value(const DriveValue& reading) {
  const auto known = std::ranges::find(read_, reading.object, &DriveValue::object);
  if (known != read_.end()) {
    known->value = reading.value;
    return;
  }
  const bool is_carried =
      std::ranges::any_of(parameters_.mapping().objects(), [&reading](const MappedObject& object) {
        return object.member == nullptr && object.address == reading.object;
      });
  if (!is_carried) return;
  read_.push_back(reading);
  note_missing_values();
}

void TransmitPdo::forget_values() {
  read_.clear();
  note_missing_values();
}

void TransmitPdo::note_missing_values() {
  misses_values_ =
      std::ranges::any_of(parameters_.mapping().objects(), [this](const MappedObject& object) {
        return !has_value(object);
      });
}

bool TransmitPdo::has_value(const MappedObject& object) const {
  return object.member != nullptr ||
         std::ranges::find(read_, object.address, &DriveValue::object) != read_.end();
}

/// @pre has_value(object)
std::int64_t TransmitPdo::value_of(const MappedObject& object, const AxisStatus& drive) const {
  if (object.member != nullptr) return object.member->value(drive);
  return std::ranges::find(read_, object.address, &DriveValue::object)->value;
}

// ---- frames ----------------------------------------------------------------------------------

std::optional<Frame> TransmitPdo::synchronise(const AxisStatus& drive, std::uint8_t counter) {
  if (!parameters_.is_valid() || misses_values_) return std::nullopt;
  const std::uint8_t type = parameters_.type();
  if (type == kRemoteSynchronous) sample_ = frame_of(drive);
  if (type > kLastSynchronous || !has_begun(counter)) return std::nullopt;
  const Frame frame = frame_of(drive);
  if (type == kAcyclicSynchronous) {
    if (sent_ == frame) return std::nullopt;
    sent_ = frame;
    return frame;
  }
  ++sync_count_;
  if (sync_count_ < type) return std::nullopt;
  sync_count_ = 0;
  return frame;
}

bool TransmitPdo::is_request(const Frame& frame) const noexcept {
  return parameters_.is_valid() && parameters_.allows_remote() && !frame.is_extended &&
         frame.is_remote && frame.id == parameters_.can_id();
}

std::optional<Frame> TransmitPdo::answer(const AxisStatus& drive, DriveTime now) {
  if (misses_values_) return std::nullopt;
  switch (parameters_.type()) {
    case kRemoteSynchronous:
      // Before the first SYNC there is no sample: the present values tell more than no answer.
      return sample_ ? *sample_ : frame_of(drive);
    case kRemoteEventDriven:
      return frame_of(drive);
    default:
      is_requested_ = is_event_driven();
      return send_due(drive, now);
  }
}

std::optional<Frame> TransmitPdo::send_due(const AxisStatus& drive, DriveTime now) {
  if (!is_event_driven()) return std::nullopt;
  const Frame present = frame_of(drive);
  const bool is_due = has_event(present, now);
  is_waiting_ = is_due && is_inhibited(now);
  if (!is_due || is_waiting_) return std::nullopt;
  return mark_sent(present, now);
}

std::optional<DriveTime> TransmitPdo::next_due() const {
  if (!is_event_driven()) return std::nullopt;
  if (!sent_) return DriveTime::zero();
  const DriveTime inhibit_time = parameters_.inhibit_time();
  const DriveTime event_time = parameters_.event_time();
  if (is_waiting_) return sent_at_ + inhibit_time;
  if (event_time == DriveTime::zero()) return std::nullopt;
  return sent_at_ + std::max(event_time, inhibit_time);
}

bool TransmitPdo::is_event_driven() const noexcept {
  return parameters_.is_valid() && !misses_values_ && parameters_.type() >= kFirstEventDriven;
}

bool TransmitPdo::has_begun(std::uint8_t counter) {
  if (!awaits_sync_start_) return true;
  const std::uint8_t start = parameters_.sync_start();
  const bool begins = start == 0 || counter == 0 || counter == start;
  awaits_sync_start_ = !begins;
  return begins;
}

bool TransmitPdo::is_inhibited(DriveTime now) const {
  return sent_ && now - sent_at_ < parameters_.inhibit_time();
}

bool TransmitPdo::has_event(const Frame& present, DriveTime now) const {
  if (!sent_ || is_requested_ || *sent_ != present) return true;
  const DriveTime event_time = parameters_.event_time();
  return event_time != DriveTime::zero() && now - sent_at_ >= event_time;
}

Frame TransmitPdo::frame_of(const AxisStatus& drive) const {
  Frame frame{.id = parameters_.can_id(), .size = parameters_.mapping().size()};
  std::span<std::uint8_t> rest(frame.data);
  for (const MappedObject& object : parameters_.mapping().objects()) {
    const std::size_t size = size_of(object.type);
    put_little_endian(static_cast<std::uint64_t>(value_of(object, drive)), rest.first(size));
    rest = rest.subspan(size);
  }
  return frame;
}

Frame TransmitPdo::mark_sent(const Frame& frame, DriveTime now) {
  sent_ = frame;
  sent_at_ = now;
  is_requested_ = false;
  return frame;
}

}  // namespace vdrive::canopen
