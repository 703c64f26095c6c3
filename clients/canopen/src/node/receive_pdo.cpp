// SPDX-License-Identifier: Apache-2.0
#include "node/receive_pdo.hpp"

#include "vdrive/dictionary/object_table.hpp"

#include <cstddef>
#include <span>

namespace vdrive::canopen {

void SetPoints::put(const DriveValue& value) {
  using namespace vdrive::literals;
  constexpr ObjectAddress kControlword = kObjectRows["ds402_controlword"_object].address;
  std::erase_if(values_, [&value](const DriveValue& earlier) {
    return earlier.object == value.object;
  });
  const bool ends_with_controlword = !values_.empty() && values_.back().object == kControlword;
  values_.insert(ends_with_controlword ? values_.end() - 1 : values_.end(), value);
}

ReceivePdo::ReceivePdo(PdoPlace place) : parameters_(PdoDirection::receive, place) {}

void ReceivePdo::reset() {
  parameters_.reset();
  restart();
}

void ReceivePdo::restart() {
  latched_.reset();
  received_.reset();
  length_error_ = 0;
  is_timed_out_ = false;
}

AbortCode ReceivePdo::write(ObjectAddress object, std::uint32_t value) {
  const bool was_valid = parameters_.is_valid();
  const std::uint8_t type = parameters_.type();
  const DriveTime event_time = parameters_.event_time();
  const AbortCode refusal = parameters_.write(object, value);
  const bool is_other = was_valid != parameters_.is_valid() || type != parameters_.type() ||
                        event_time != parameters_.event_time();
  if (is_other) restart();
  return refusal;
}

bool ReceivePdo::awaits(const Frame& frame) const noexcept {
  return parameters_.is_valid() && !frame.is_extended && !frame.is_remote &&
         frame.id == parameters_.can_id();
}

bool ReceivePdo::is_synchronous() const noexcept {
  return parameters_.type() <= kLastSynchronous;
}

PdoReception ReceivePdo::receive(const Frame& frame, DriveTime now) {
  const std::size_t awaited = parameters_.mapping().size();
  std::uint16_t error = 0;
  if (frame.size < awaited) error = kPdoTooShort;
  if (frame.size > awaited) error = kPdoTooLong;
  const bool is_news = error != length_error_;
  length_error_ = error;
  const bool is_dropped = error == kPdoTooShort;
  if (!is_dropped) {
    latched_ = frame;
    received_ = now;
    is_timed_out_ = false;
  }
  return {.is_dropped = is_dropped, .error_code = is_news ? error : std::uint16_t{0}};
}

bool ReceivePdo::take(SetPoints& set_points) {
  if (!latched_) return false;
  const std::span<const std::uint8_t> bytes = latched_->data;
  std::size_t begin = 0;
  for (const MappedObject& object : parameters_.mapping().objects()) {
    const std::size_t size = size_of(object.type);
    if (!object.is_dummy()) {
      set_points.put({object.address, number_of(object.type, bytes.subspan(begin, size))});
    }
    begin += size;
  }
  latched_.reset();
  return true;
}

bool ReceivePdo::times_out(DriveTime now) {
  const std::optional<DriveTime> due = next_due();
  if (!due || now < *due) return false;
  received_.reset();
  is_timed_out_ = true;
  return true;
}

std::optional<DriveTime> ReceivePdo::next_due() const {
  const DriveTime event_time = parameters_.event_time();
  if (!received_ || event_time == DriveTime::zero()) return std::nullopt;
  return *received_ + event_time;
}

}  // namespace vdrive::canopen
