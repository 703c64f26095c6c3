// SPDX-License-Identifier: Apache-2.0
#include "bus/sdo_client.hpp"

#include "node/cob_id.hpp"
#include "node/frame.hpp"
#include "vdrive/assert.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace vdrive::canopen {
namespace {

// Command specifiers: the three highest bits of the first byte (CiA 301, 7.2.4.3).
constexpr std::uint32_t kSpecifier = 0xE0;
constexpr std::uint32_t kAbortTransfer = 0x80;  // used by both sides
constexpr std::uint32_t kInitiateRead = 0x40;   // used by both sides
constexpr std::uint32_t kReadSegment = 0x60;
constexpr std::uint32_t kReadSegmentAnswer = 0x00;
constexpr std::uint32_t kInitiateWrite = 0x20;
constexpr std::uint32_t kInitiateWriteAnswer = 0x60;
constexpr std::uint32_t kWriteSegment = 0x00;
constexpr std::uint32_t kWriteSegmentAnswer = 0x20;

// The lower bits.
constexpr std::uint32_t kToggle = 0x10;
constexpr std::uint32_t kIsExpedited = 0x02;
constexpr std::uint32_t kHasSize = 0x01;
constexpr std::uint32_t kIsLast = 0x01;

constexpr std::size_t kExpeditedData = 4;  // [bytes], after command and multiplexer
constexpr std::size_t kSegmentData = 7;    // [bytes], after the command

void put_number(Frame& frame, std::size_t place, std::uint32_t number) {
  put_little_endian(number, std::span(frame.data).subspan(place, sizeof number));
}

std::uint32_t number_at(const Frame& frame, std::size_t place) {
  const auto bytes = std::span(frame.data).subspan(place, sizeof(std::uint32_t));
  return static_cast<std::uint32_t>(little_endian_number(bytes));
}

}  // namespace

void SdoClient::read(ObjectAddress object, std::chrono::milliseconds time_out, BusTime now) {
  data_.clear();
  begin(Step::read_start, object, time_out, now);
  send_request(initiate(kInitiateRead), now);
}

void SdoClient::write(ObjectAddress object, std::vector<std::uint8_t> data,
                      std::chrono::milliseconds time_out, BusTime now) {
  data_ = std::move(data);
  begin(Step::write_start, object, time_out, now);
  const std::size_t size = data_.size();
  if (size == 0 || size > kExpeditedData) {
    Frame frame = initiate(kInitiateWrite | kHasSize);
    put_number(frame, kExpeditedData, static_cast<std::uint32_t>(size));
    return send_request(frame, now);
  }
  const auto unused = static_cast<std::uint32_t>(kExpeditedData - size);
  Frame frame = initiate(kInitiateWrite | unused << 2U | kIsExpedited | kHasSize);
  std::ranges::copy(data_, frame.data.begin() + kExpeditedData);
  position_ = size;
  send_request(frame, now);
}

void SdoClient::cancel(AbortCode reason) {
  if (step_ == Step::idle) return;
  step_ = Step::idle;
  send_abort(reason);
}

bool SdoClient::is_for(const Frame& frame) const noexcept {
  return frame.id == kSdoResponseId + node_id_ && frame.size == kMostData && !frame.is_extended &&
         !frame.is_remote;
}

void SdoClient::receive(const Frame& frame, BusTime now) {
  if (step_ == Step::idle || !is_for(frame)) return;
  if ((frame.data[0] & kSpecifier) == kAbortTransfer) {
    // An abort for another object is the late end of a transfer that was given up.
    if (has_multiplexer(frame)) finish(static_cast<AbortCode>(number_at(frame, kExpeditedData)));
    return;
  }
  switch (step_) {
    case Step::idle:
      return;
    case Step::read_start:
      return on_read_started(frame, now);
    case Step::read_segment:
      return on_read_segment(frame, now);
    case Step::write_start:
      return on_write_started(frame, now);
    case Step::write_segment:
      return on_write_segment(frame, now);
  }
}

void SdoClient::advance(BusTime now) {
  if (step_ != Step::idle && now >= due_) break_off(AbortCode::protocol_timed_out);
}

std::optional<BusTime> SdoClient::next_due() const noexcept {
  return step_ == Step::idle ? std::nullopt : std::optional(due_);
}

std::optional<SdoOutcome> SdoClient::take_outcome() {
  return std::exchange(outcome_, std::nullopt);
}

void SdoClient::begin(Step step, ObjectAddress object, std::chrono::milliseconds time_out,
                      BusTime now) {
  ensure(step_ == Step::idle && !outcome_, "an SDO client has one transfer at a time");
  step_ = step;
  object_ = object;
  position_ = 0;
  size_.reset();
  toggle_ = false;
  time_out_ = time_out;
  due_ = now + time_out;
}

bool SdoClient::has_multiplexer(const Frame& frame) const noexcept {
  const auto index = static_cast<std::uint32_t>(frame.data[1] | frame.data[2] << 8);
  return index == object_.index && frame.data[3] == object_.subindex;
}

Frame SdoClient::initiate(std::uint32_t command) const noexcept {
  Frame frame{.id = kSdoRequestId + node_id_, .size = kMostData};
  frame.data[0] = static_cast<std::uint8_t>(command);
  frame.data[1] = static_cast<std::uint8_t>(object_.index & 0xFFU);
  frame.data[2] = static_cast<std::uint8_t>(object_.index >> 8U);
  frame.data[3] = object_.subindex;
  return frame;
}

void SdoClient::on_read_started(const Frame& frame, BusTime now) {
  if (!has_multiplexer(frame)) return;
  const std::uint32_t command = frame.data[0];
  if ((command & kSpecifier) != kInitiateRead) {
    return break_off(AbortCode::unknown_command_specifier);
  }
  if ((command & kIsExpedited) != 0) {
    // Without a size all four bytes belong to the value.
    const std::size_t unused = (command & kHasSize) != 0 ? command >> 2U & 3U : 0;
    const auto begin = frame.data.begin() + kExpeditedData;
    data_.assign(begin, begin + static_cast<std::ptrdiff_t>(kExpeditedData - unused));
    return finish(AbortCode::none);
  }
  if ((command & kHasSize) != 0) size_ = number_at(frame, kExpeditedData);
  if (size_ > kLongestValue) return break_off(AbortCode::out_of_memory);
  step_ = Step::read_segment;
  request_segment(now);
}

void SdoClient::on_read_segment(const Frame& frame, BusTime now) {
  const std::uint32_t command = frame.data[0];
  if ((command & kSpecifier) != kReadSegmentAnswer) {
    return break_off(AbortCode::unknown_command_specifier);
  }
  if (!is_toggle_right(command)) return;
  const std::size_t bytes = kSegmentData - (command >> 1U & 7U);
  const auto begin = frame.data.begin() + 1;
  data_.insert(data_.end(), begin, begin + static_cast<std::ptrdiff_t>(bytes));
  if (data_.size() > size_.value_or(kLongestValue)) return break_off(AbortCode::length_too_high);
  if ((command & kIsLast) == 0) {
    toggle_ = !toggle_;
    return request_segment(now);
  }
  if (size_ && data_.size() != *size_) return break_off(AbortCode::data_length_does_not_match);
  finish(AbortCode::none);
}

void SdoClient::on_write_started(const Frame& frame, BusTime now) {
  if (!has_multiplexer(frame)) return;
  if ((frame.data[0] & kSpecifier) != kInitiateWriteAnswer) {
    return break_off(AbortCode::unknown_command_specifier);
  }
  if (position_ == data_.size() && !data_.empty()) return finish(AbortCode::none);  // expedited
  step_ = Step::write_segment;
  send_segment(now);
}

void SdoClient::on_write_segment(const Frame& frame, BusTime now) {
  if ((frame.data[0] & kSpecifier) != kWriteSegmentAnswer) {
    return break_off(AbortCode::unknown_command_specifier);
  }
  if (!is_toggle_right(frame.data[0])) return;
  if (position_ == data_.size()) return finish(AbortCode::none);
  toggle_ = !toggle_;
  send_segment(now);
}

void SdoClient::request_segment(BusTime now) {
  Frame frame{.id = kSdoRequestId + node_id_, .size = kMostData};
  frame.data[0] = static_cast<std::uint8_t>(kReadSegment | (toggle_ ? kToggle : 0U));
  send_request(frame, now);
}

void SdoClient::send_segment(BusTime now) {
  const std::size_t bytes = std::min(kSegmentData, data_.size() - position_);
  const auto begin = data_.begin() + static_cast<std::ptrdiff_t>(position_);
  position_ += bytes;
  const auto unused = static_cast<std::uint32_t>(kSegmentData - bytes);
  Frame frame{.id = kSdoRequestId + node_id_, .size = kMostData};
  frame.data[0] =
      static_cast<std::uint8_t>(kWriteSegment | (toggle_ ? kToggle : 0U) | unused << 1U |
                                (position_ == data_.size() ? kIsLast : 0U));
  std::copy_n(begin, bytes, frame.data.begin() + 1);
  send_request(frame, now);
}

/// Ends the transfer if the toggle bit of an answer is wrong.
bool SdoClient::is_toggle_right(std::uint32_t command) {
  if (((command & kToggle) != 0) == toggle_) return true;
  break_off(AbortCode::toggle_bit_not_alternated);
  return false;
}

void SdoClient::send_request(const Frame& frame, BusTime now) {
  due_ = now + time_out_;
  sender_.send(frame);
}

void SdoClient::finish(AbortCode abort) {
  const bool has_value = step_ == Step::read_start || step_ == Step::read_segment;
  step_ = Step::idle;
  outcome_.emplace(SdoOutcome{.abort = abort, .data = {}});
  if (has_value && abort == AbortCode::none) outcome_->data = std::move(data_);
  data_.clear();
}

void SdoClient::break_off(AbortCode reason) {
  send_abort(reason);
  finish(reason);
}

void SdoClient::send_abort(AbortCode reason) const {
  Frame frame = initiate(kAbortTransfer);
  put_number(frame, kExpeditedData, wire_code(reason));
  sender_.send(frame);
}

}  // namespace vdrive::canopen
