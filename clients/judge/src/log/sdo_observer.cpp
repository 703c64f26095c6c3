// SPDX-License-Identifier: Apache-2.0
#include "log/sdo_observer.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace vdrive::judge {
namespace {

using canopen::Frame;

// Command specifiers, bits 5 to 7 of the first byte (CiA 301, 7.2.4.3).
constexpr unsigned kDownloadSegment = 0;
constexpr unsigned kInitiateDownload = 1;
constexpr unsigned kInitiateUpload = 2;
constexpr unsigned kUploadSegment = 3;
constexpr unsigned kAbort = 4;
constexpr unsigned kBlockOfTheSender = 5;
constexpr unsigned kBlockOfTheReceiver = 6;

// Lower bits of the first byte.
constexpr unsigned kIsExpedited = 0x02;
constexpr unsigned kHasSize = 0x01;
constexpr unsigned kIsLast = 0x01;
constexpr unsigned kBlockSubcommand = 0x03;
constexpr unsigned kBlockEnd = 0x01;
constexpr unsigned kStartUpload = 0x03;
constexpr unsigned kLastSegmentOfBlock = 0x80;

constexpr std::size_t kNumberPlace = 4;
constexpr std::size_t kSegmentBytes = 7;

unsigned specifier_of(const Frame& frame) {
  return frame.data[0] >> 5U;
}

ObjectAddress object_of(const Frame& frame) {
  return {.index = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8U),
          .subindex = frame.data[3]};
}

std::uint32_t number_of_frame(const Frame& frame) {
  return static_cast<std::uint32_t>(
      canopen::little_endian_number(std::span(frame.data).subspan(kNumberPlace)));
}

/// The number of bytes in an expedited transfer.
std::size_t expedited_size(const Frame& frame) {
  return (frame.data[0] & kHasSize) != 0 ? 4U - (frame.data[0] >> 2U & 3U) : 4U;
}

/// The number of bytes in a segment.
std::size_t segment_size(const Frame& frame) {
  return kSegmentBytes - (frame.data[0] >> 1U & 7U);
}

}  // namespace

void SdoObserver::forget() noexcept {
  step_ = Step::idle;
  is_sent_ = false;
  is_in_block_ = false;
  is_last_block_ = false;
}

void SdoObserver::begin(Step step, const Frame& frame) {
  forget();
  step_ = step;
  transfer_ = {.is_download = step == Step::download || step == Step::block_download,
               .object = object_of(frame)};
}

void SdoObserver::put(const Frame& frame, std::size_t first, std::size_t count) {
  const auto bytes = std::span(frame.data).subspan(first, count);
  if (transfer_.data.size() + count > kMostData) return;
  transfer_.data.insert(transfer_.data.end(), bytes.begin(), bytes.end());
}

std::optional<SdoTransfer> SdoObserver::finish() {
  forget();
  return std::move(transfer_);
}

std::optional<SdoTransfer> SdoObserver::take_request(const Frame& frame) {
  const bool is_abort = specifier_of(frame) == kAbort;
  if (step_ == Step::block_download && is_in_block_ && frame.data[0] != kAbort << 5U) {
    is_last_block_ = is_last_block_ || (frame.data[0] & kLastSegmentOfBlock) != 0;
    return std::nullopt;
  }
  if (is_abort) return take_abort(frame);
  switch (specifier_of(frame)) {
    case kInitiateDownload:
      begin_download(frame);
      break;
    case kDownloadSegment:
      if (step_ != Step::download) break;
      put(frame, 1, segment_size(frame));
      is_sent_ = (frame.data[0] & kIsLast) != 0;
      break;
    case kInitiateUpload:
      begin(Step::upload, frame);
      break;
    case kBlockOfTheReceiver:  // block download: initiate or end
      if ((frame.data[0] & kBlockEnd) == 0) begin(Step::block_download, frame);
      transfer_.is_complete = false;
      break;
    case kBlockOfTheSender:  // block upload: initiate, start or confirmation
      begin_block_upload(frame);
      break;
    default:
      break;
  }
  return std::nullopt;
}

void SdoObserver::begin_download(const Frame& frame) {
  begin(Step::download, frame);
  is_sent_ = (frame.data[0] & kIsExpedited) != 0;
  if (is_sent_) put(frame, kNumberPlace, expedited_size(frame));
}

void SdoObserver::begin_block_upload(const Frame& frame) {
  if ((frame.data[0] & kBlockSubcommand) == 0) begin(Step::block_upload, frame);
  if ((frame.data[0] & kBlockSubcommand) == kStartUpload) is_in_block_ = true;
  transfer_.is_complete = false;
}

std::optional<SdoTransfer> SdoObserver::take_abort(const Frame& frame) {
  if (step_ == Step::idle || object_of(frame) != transfer_.object) return std::nullopt;
  transfer_.abort = number_of_frame(frame);
  return finish();
}

std::optional<SdoTransfer> SdoObserver::take_response(const Frame& frame) {
  // Segments of a block upload start with a sequence number from 1: 80h is not one.
  const bool is_segment =
      step_ == Step::block_upload && is_in_block_ && frame.data[0] != kAbort << 5U;
  if (specifier_of(frame) == kAbort && !is_segment) return take_abort(frame);
  switch (step_) {
    case Step::idle:
      return std::nullopt;
    case Step::download: {
      // Confirms the initiate request or a segment.
      const bool is_confirmed =
          specifier_of(frame) == kUploadSegment || specifier_of(frame) == kInitiateDownload;
      return is_confirmed && is_sent_ ? finish() : std::nullopt;
    }
    case Step::upload:
      return take_upload(frame);
    case Step::block_download:
      if ((frame.data[0] & kBlockSubcommand) == kBlockEnd) return finish();
      is_in_block_ = !is_last_block_;  // confirms the initiate request or a block
      return std::nullopt;
    case Step::block_upload:
      return take_block_upload(frame);
  }
  return std::nullopt;
}

std::optional<SdoTransfer> SdoObserver::take_upload(const Frame& frame) {
  if (specifier_of(frame) == kInitiateUpload) {
    const bool is_expedited = (frame.data[0] & kIsExpedited) != 0;
    if (object_of(frame) != transfer_.object || !is_expedited) return std::nullopt;
    put(frame, kNumberPlace, expedited_size(frame));
    return finish();
  }
  if (specifier_of(frame) != kDownloadSegment) return std::nullopt;
  put(frame, 1, segment_size(frame));
  return (frame.data[0] & kIsLast) != 0 ? finish() : std::nullopt;
}

std::optional<SdoTransfer> SdoObserver::take_block_upload(const Frame& frame) {
  if (is_in_block_) {
    is_in_block_ = (frame.data[0] & kLastSegmentOfBlock) == 0;
    return std::nullopt;
  }
  const bool is_end =
      specifier_of(frame) == kBlockOfTheReceiver && (frame.data[0] & kBlockEnd) != 0;
  return is_end ? finish() : std::nullopt;
}

}  // namespace vdrive::judge
