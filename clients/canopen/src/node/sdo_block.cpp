// SPDX-License-Identifier: Apache-2.0
#include "node/sdo_block.hpp"

#include "node/cob_id.hpp"

#include <algorithm>
#include <utility>

namespace vdrive::canopen {
namespace {

// First bytes: specifier in bits 5 to 7, subcommand in bits 0 and 1.
constexpr std::uint8_t kConfirmUploadBlock = 0xA2;
constexpr std::uint8_t kEndOfUpload = 0xC1;
constexpr std::uint8_t kConfirmUploadEnd = 0xA1;
constexpr std::uint8_t kStartUpload = 0xA3;
constexpr std::uint8_t kConfirmDownloadBlock = 0xA2;
constexpr std::uint8_t kEndOfDownload = 0xC1;

constexpr std::uint8_t kSpecifierAndSubcommand = 0xE3;
constexpr unsigned kUnusedBytes = 2;  ///< in an end request: bits 2 to 4

// First byte of a segment: its number in the block, from 1 on, and whether it is the last one of
// the transfer.
constexpr std::uint8_t kLastOfAll = 0x80;
constexpr std::uint8_t kNumber = 0x7F;

constexpr std::size_t kSegmentBytes = 7;

std::uint16_t crc_of(const Frame& request) {
  return static_cast<std::uint16_t>(request.data[1] | request.data[2] << 8U);
}

std::uint8_t command_of(const Frame& request) {
  return request.data[0] & kSpecifierAndSubcommand;
}

}  // namespace

std::uint16_t sdo_crc(std::string_view data) noexcept {
  constexpr std::uint32_t kPolynomial = 0x1021;
  constexpr std::uint32_t kTopBit = 0x8000;
  std::uint32_t crc = 0;
  for (const char byte : data) {
    crc ^= std::uint32_t{static_cast<std::uint8_t>(byte)} << 8U;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & kTopBit) != 0 ? crc << 1U ^ kPolynomial : crc << 1U;
    }
  }
  return static_cast<std::uint16_t>(crc);
}

SdoBlockUpload::SdoBlockUpload(std::uint8_t node_id, NodeHost& host, std::string data,
                               const SdoBlockTerms& terms)
    : node_id_(node_id), host_(host), data_(std::move(data)), terms_(terms) {}

SdoBlockStep SdoBlockUpload::receive(const Frame& request) {
  const std::uint8_t command = command_of(request);
  if (phase_ == Phase::begun && command == kStartUpload) {
    send_block();
    return {};
  }
  if (phase_ == Phase::in_block && command == kConfirmUploadBlock) {
    return take_confirmation(request);
  }
  if (phase_ == Phase::ended && command == kConfirmUploadEnd) return {.is_complete = true};
  return {.abort = AbortCode::unknown_command_specifier};
}

SdoBlockStep SdoBlockUpload::take_confirmation(const Frame& request) {
  const std::uint8_t received = request.data[1];
  terms_.segments = request.data[2];
  if (received > sent_) return {.abort = kInvalidSequenceNumber};
  confirmed_ = std::min(confirmed_ + received * kSegmentBytes, data_.size());
  // An empty text is sent as one segment without data.
  if (confirmed_ == data_.size() && received != 0) {
    send_end();
    return {};
  }
  if (terms_.segments == 0 || terms_.segments > kMostSegments) return {.abort = kInvalidBlockSize};
  send_block();
  return {};
}

void SdoBlockUpload::send_block() {
  phase_ = Phase::in_block;
  std::size_t position = confirmed_;
  for (sent_ = 0; sent_ < terms_.segments;) {
    Frame segment{.id = kSdoResponseId + node_id_, .size = kMostData};
    const std::string_view bytes = std::string_view(data_).substr(position, kSegmentBytes);
    std::ranges::transform(bytes, segment.data.begin() + 1, [](char byte) {
      return static_cast<std::uint8_t>(byte);
    });
    position += bytes.size();
    segment.data[0] = ++sent_;
    const bool is_last = position == data_.size();
    if (is_last) segment.data[0] |= kLastOfAll;
    host_.send(segment);
    if (is_last) return;
  }
}

void SdoBlockUpload::send_end() {
  phase_ = Phase::ended;
  const std::size_t rest = data_.size() % kSegmentBytes;
  const std::size_t unused = data_.empty() ? kSegmentBytes : (kSegmentBytes - rest) % kSegmentBytes;
  const std::uint16_t crc = terms_.has_crc ? sdo_crc(data_) : std::uint16_t{0};
  Frame end{.id = kSdoResponseId + node_id_, .size = kMostData};
  end.data[0] = static_cast<std::uint8_t>(kEndOfUpload | unused << kUnusedBytes);
  end.data[1] = static_cast<std::uint8_t>(crc & 0xFFU);
  end.data[2] = static_cast<std::uint8_t>(crc >> 8U);
  host_.send(end);
}

SdoBlockDownload::SdoBlockDownload(std::uint8_t node_id, NodeHost& host, std::size_t size,
                                   bool has_crc)
    : node_id_(node_id), host_(host), size_(size), has_crc_(has_crc) {}

SdoBlockStep SdoBlockDownload::receive(const Frame& request) {
  return is_in_block_ ? take_segment(request) : take_end(request);
}

/// The client repeats a segment that is out of order, and those after it: the confirmation names
/// the last segment in order.
SdoBlockStep SdoBlockDownload::take_segment(const Frame& segment) {
  const std::uint8_t number = segment.data[0] & kNumber;
  if (number == 0) return {.abort = kInvalidSequenceNumber};
  const bool is_last = (segment.data[0] & kLastOfAll) != 0;
  const bool is_next = number == taken_ + 1;
  if (is_next) {
    ++taken_;
    for (std::size_t i = 1; i <= kSegmentBytes; ++i) {
      data_.push_back(static_cast<char>(segment.data.at(i)));
    }
    // At least one byte of each segment is used.
    if (data_.size() >= size_ + kSegmentBytes) return {.abort = AbortCode::length_too_high};
  }
  if (!is_last && number != kMostSegments) return {};
  is_in_block_ = !(is_last && is_next);
  Frame confirmation{.id = kSdoResponseId + node_id_, .size = kMostData};
  confirmation.data[0] = kConfirmDownloadBlock;
  confirmation.data[1] = std::exchange(taken_, std::uint8_t{0});
  confirmation.data[2] = kMostSegments;
  host_.send(confirmation);
  return {};
}

SdoBlockStep SdoBlockDownload::take_end(const Frame& request) {
  if (command_of(request) != kEndOfDownload) {
    return {.abort = AbortCode::unknown_command_specifier};
  }
  const std::size_t unused = request.data[0] >> kUnusedBytes & 0x07U;
  data_.resize(data_.size() - std::min(unused, data_.size()));
  if (data_.size() > size_) return {.abort = AbortCode::length_too_high};
  if (data_.size() < size_) return {.abort = AbortCode::length_too_low};
  if (has_crc_ && crc_of(request) != sdo_crc(data_)) return {.abort = kCrcError};
  return {.is_complete = true};
}

}  // namespace vdrive::canopen
