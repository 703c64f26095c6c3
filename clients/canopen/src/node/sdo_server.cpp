// SPDX-License-Identifier: Apache-2.0
#include "node/sdo_server.hpp"

#include "node/cob_id.hpp"
#include "node/frame.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace vdrive::canopen {
namespace {

// Bits 5 to 7 of the first byte: the client's command (CiA 301, 7.2.4.3).
enum class ClientCommand : std::uint8_t {
  download_segment = 0,
  initiate_download = 1,
  initiate_upload = 2,
  upload_segment = 3,
  abort = 4,
  block_upload = 5,
  block_download = 6,
};

// First bytes of responses.
constexpr std::uint8_t kUploadSegmentResponse = 0x00;
constexpr std::uint8_t kDownloadSegmentResponse = 0x20;
constexpr std::uint8_t kUploadResponse = 0x40;
constexpr std::uint8_t kDownloadResponse = 0x60;
constexpr std::uint8_t kAbort = 0x80;
constexpr std::uint8_t kBlockUploadResponse = 0xC0;
constexpr std::uint8_t kBlockDownloadResponse = 0xA0;
constexpr std::uint8_t kBlockDownloadEndResponse = 0xA1;

// Bits of an initiate request or response.
constexpr std::uint8_t kSizeIndicated = 0x01;
constexpr std::uint8_t kExpedited = 0x02;
constexpr std::uint8_t kBlockSizeIndicated = 0x02;  ///< in a block transfer
constexpr std::uint8_t kCrcSupported = 0x04;        ///< in a block transfer

// Bits of a segment.
constexpr std::uint8_t kLastSegment = 0x01;
constexpr std::uint8_t kToggle = 0x10;

constexpr std::size_t kExpeditedData = 4;
constexpr std::size_t kSegmentData = 7;

ClientCommand client_command_of(const Frame& request) {
  return static_cast<ClientCommand>(request.data[0] >> 5U);
}

/// Bytes 1 to 3: the multiplexer.
ObjectAddress multiplexer_of(const Frame& request) {
  return {.index = static_cast<std::uint16_t>(request.data[1] | request.data[2] << 8U),
          .subindex = request.data[3]};
}

/// Bytes 4 to 7.
std::uint32_t indicated_size(const Frame& request) {
  const auto bytes = std::span(request.data).subspan(kExpeditedData);
  return static_cast<std::uint32_t>(little_endian_number(bytes));
}

/// @return whether the request names an object: only initiate requests do.
bool names_object(const Frame& request) {
  switch (client_command_of(request)) {
    case ClientCommand::initiate_download:
    case ClientCommand::initiate_upload:
      return true;
    case ClientCommand::block_upload:
      return (request.data[0] & 0x03U) == 0;  // initiate, one of four subcommands
    case ClientCommand::block_download:
      return (request.data[0] & 0x01U) == 0;  // initiate, one of two
    default:
      return false;
  }
}

AbortCode check_size(std::size_t size, std::size_t expected) {
  if (size > expected) return AbortCode::length_too_high;
  return size < expected ? AbortCode::length_too_low : AbortCode::none;
}

std::array<std::uint8_t, 4> sdo_bytes_of(std::uint32_t number) {
  std::array<std::uint8_t, 4> bytes{};
  put_little_endian(number, bytes);
  return bytes;
}

}  // namespace

SdoServer::SdoServer(std::uint8_t node_id, NodeHost& host, SdoObjects& objects)
    : node_id_(node_id), host_(host), objects_(objects) {}

void SdoServer::receive(const Frame& request, DriveTime now) {
  const bool is_segment = is_in_block() && request.data[0] != kAbort;
  if (client_command_of(request) == ClientCommand::abort && !is_segment) {
    stop();  // a client has one channel, so the abort also covers its waiting requests
  } else if (!access_) {
    serve(request, now);
  } else if (!waiting_.put(request)) {
    send_abort(object_of(request), AbortCode::out_of_memory);
  }
}

void SdoServer::serve(const Frame& request, DriveTime now) {
  if (is_in_block()) return continue_block(request, now);
  switch (client_command_of(request)) {
    case ClientCommand::initiate_upload:
      return initiate_upload(request, now);
    case ClientCommand::initiate_download:
      return initiate_download(request, now);
    case ClientCommand::upload_segment:
      return upload_segment(request, now);
    case ClientCommand::download_segment:
      return download_segment(request, now);
    case ClientCommand::block_upload:
      return names_object(request) ? initiate_block_upload(request, now)
                                   : continue_block(request, now);
    case ClientCommand::block_download:
      return names_object(request) ? initiate_block_download(request, now)
                                   : continue_block(request, now);
    default:
      return refuse_command(request);
  }
}

/// Ends the transfer because of an unexpected request.
void SdoServer::refuse_command(const Frame& request) {
  const ObjectAddress object = object_of(request);
  end_transfer();
  send_abort(object, AbortCode::unknown_command_specifier);
}

void SdoServer::finish(const SdoAnswer& answer, DriveTime now) {
  if (!access_) return;
  const Access access = *access_;
  access_.reset();
  if (access.is_wanted) conclude(access, answer, now);
  while (!access_ && !waiting_.empty()) serve(*waiting_.take(), now);
}

void SdoServer::stop() {
  end_transfer();
  waiting_.clear();
  if (access_) access_->is_wanted = false;
}

void SdoServer::reset() {
  stop();
  access_.reset();
}

void SdoServer::advance(DriveTime now) {
  if (transfer_ == Transfer::none || now < deadline_) return;
  ++counters_.time_outs;
  end_transfer();
  send_abort(object_, AbortCode::protocol_timed_out);
}

std::optional<DriveTime> SdoServer::next_due() const {
  return transfer_ == Transfer::none ? std::nullopt : std::optional(deadline_);
}

void SdoServer::initiate_upload(const Frame& request, DriveTime now) {
  end_transfer();
  begin_upload({.object = multiplexer_of(request), .transfer = Transfer::upload}, now);
}

void SdoServer::begin_upload(const Access& access, DriveTime now) {
  if (const auto answer = objects_.begin_upload(access.object)) {
    conclude(access, *answer, now);
  } else {
    access_ = access;
  }
}

void SdoServer::initiate_download(const Frame& request, DriveTime now) {
  end_transfer();
  const ObjectAddress object = multiplexer_of(request);
  const SdoTarget target = objects_.check_download(object);
  if (target.abort != AbortCode::none) return send_abort(object, target.abort);
  const std::uint8_t flags = request.data[0];
  if ((flags & kExpedited) == 0) return initiate_segments(request, target, now);
  // If no size is indicated, the size of the object applies.
  const std::size_t size =
      (flags & kSizeIndicated) != 0 ? kExpeditedData - (flags >> 2U & 0x03U) : target.size;
  if (const AbortCode code = check_size(size, target.size); code != AbortCode::none) {
    return send_abort(object, code);
  }
  download({.object = object, .transfer = Transfer::download, .response = kDownloadResponse},
           std::span(request.data).subspan(kExpeditedData, size), now);
}

void SdoServer::initiate_segments(const Frame& request, const SdoTarget& target, DriveTime now) {
  const ObjectAddress object = multiplexer_of(request);
  if ((request.data[0] & kSizeIndicated) != 0) {
    const AbortCode code = check_size(indicated_size(request), target.size);
    if (code != AbortCode::none) return send_abort(object, code);
  }
  transfer_ = Transfer::download;
  object_ = object;
  size_ = target.size;
  deadline_ = now + kClientTimeOut;
  send(kDownloadResponse, object, {});
}

void SdoServer::download_segment(const Frame& request, DriveTime now) {
  if (!check_segment(request, Transfer::download)) return;
  const std::uint8_t flags = request.data[0];
  const std::size_t unused = flags >> 1U & 0x07U;
  const bool is_last = (flags & kLastSegment) != 0;
  for (std::size_t i = 1; i <= kSegmentData - unused; ++i) {
    data_.push_back(static_cast<char>(request.data[i]));
  }
  const AbortCode code = check_size(data_.size(), size_);
  if (code == AbortCode::length_too_high || (is_last && code != AbortCode::none)) {
    end_transfer();
    return send_abort(object_, code);
  }
  const auto response = static_cast<std::uint8_t>(kDownloadSegmentResponse | (flags & kToggle));
  if (!is_last) {
    continue_transfer(now);
    return send(response, {}, {});
  }
  std::array<std::uint8_t, kExpeditedData> received{};
  std::ranges::transform(data_, received.begin(), [](char byte) {
    return static_cast<std::uint8_t>(byte);
  });
  const std::size_t size = data_.size();
  end_transfer();
  download({.object = object_, .transfer = Transfer::download, .response = response},
           std::span(received).first(size), now);
}

void SdoServer::download(const Access& access, std::span<const std::uint8_t> data, DriveTime now) {
  if (const auto answer = objects_.begin_download(access.object, data, now)) {
    conclude(access, *answer, now);
  } else {
    access_ = access;
  }
}

void SdoServer::conclude(const Access& access, const SdoAnswer& answer, DriveTime now) {
  if (answer.abort != AbortCode::none) {
    send_abort(access.object, answer.abort);
  } else if (access.block) {
    conclude_block_upload(access, answer, now);
  } else if (access.transfer == Transfer::upload) {
    conclude_upload(access.object, answer, now);
  } else {
    // The response to a segment, and to the end of a block transfer, names no object.
    const bool is_segment = access.response != kDownloadResponse;
    send(access.response, is_segment ? ObjectAddress{} : access.object, {});
  }
}

void SdoServer::conclude_upload(ObjectAddress object, const SdoAnswer& answer, DriveTime now) {
  const std::size_t size = answer.bytes.size();
  if (answer.is_text || size > kExpeditedData) {
    transfer_ = Transfer::upload;
    object_ = object;
    data_ = answer.bytes;
    position_ = 0;
    deadline_ = now + kClientTimeOut;
    return send(kUploadResponse | kSizeIndicated, object,
                sdo_bytes_of(static_cast<std::uint32_t>(size)));
  }
  std::array<std::uint8_t, kExpeditedData> data{};
  std::ranges::transform(answer.bytes, data.begin(), [](char byte) {
    return static_cast<std::uint8_t>(byte);
  });
  const std::size_t unused = kExpeditedData - size;
  send(static_cast<std::uint8_t>(kUploadResponse | unused << 2U | kExpedited | kSizeIndicated),
       object, data);
}

void SdoServer::upload_segment(const Frame& request, DriveTime now) {
  if (!check_segment(request, Transfer::upload)) return;
  const std::size_t size = std::min(data_.size() - position_, kSegmentData);
  Frame response{.id = kSdoResponseId + node_id_, .size = kMostData};
  for (std::size_t i = 0; i < size; ++i) {
    response.data[i + 1] = static_cast<std::uint8_t>(data_[position_ + i]);
  }
  position_ += size;
  const bool is_last = position_ == data_.size();
  response.data[0] =
      static_cast<std::uint8_t>(kUploadSegmentResponse | (request.data[0] & kToggle) |
                                (kSegmentData - size) << 1U | (is_last ? kLastSegment : 0U));
  if (is_last) {
    end_transfer();
  } else {
    continue_transfer(now);
  }
  host_.send(response);
}

// ---- block transfer ---------------------------------------------------------------------------

bool SdoServer::is_in_block() const {
  const auto* const received = std::get_if<SdoBlockDownload>(&block_);
  return received != nullptr && received->is_in_block();
}

void SdoServer::initiate_block_upload(const Frame& request, DriveTime now) {
  end_transfer();
  const ObjectAddress object = multiplexer_of(request);
  const std::uint8_t segments = request.data[4];
  if (segments == 0 || segments > kMostSegments) return send_abort(object, kInvalidBlockSize);
  const bool has_crc = (request.data[0] & kCrcSupported) != 0;
  begin_upload({.object = object,
                .transfer = Transfer::upload,
                .block = SdoBlockTerms{.segments = segments, .has_crc = has_crc}},
               now);
}

/// Always in blocks: the client's protocol switch threshold permits another protocol but does not
/// require it.
void SdoServer::conclude_block_upload(const Access& access, const SdoAnswer& answer,
                                      DriveTime now) {
  block_.emplace<SdoBlockUpload>(node_id_, host_, answer.bytes, *access.block);
  begin_block(access.object, now);
  send(kBlockUploadResponse | kCrcSupported | kBlockSizeIndicated, access.object,
       sdo_bytes_of(static_cast<std::uint32_t>(answer.bytes.size())));
}

void SdoServer::initiate_block_download(const Frame& request, DriveTime now) {
  end_transfer();
  const ObjectAddress object = multiplexer_of(request);
  const SdoTarget target = objects_.check_download(object);
  if (target.abort != AbortCode::none) return send_abort(object, target.abort);
  if ((request.data[0] & kBlockSizeIndicated) != 0) {
    const AbortCode code = check_size(indicated_size(request), target.size);
    if (code != AbortCode::none) return send_abort(object, code);
  }
  const bool has_crc = (request.data[0] & kCrcSupported) != 0;
  block_.emplace<SdoBlockDownload>(node_id_, host_, target.size, has_crc);
  begin_block(object, now);
  send(kBlockDownloadResponse | kCrcSupported, object, std::array{kMostSegments});
}

void SdoServer::begin_block(ObjectAddress object, DriveTime now) {
  transfer_ = Transfer::block;
  object_ = object;
  deadline_ = now + kClientTimeOut;
}

void SdoServer::continue_block(const Frame& request, DriveTime now) {
  if (transfer_ != Transfer::block) return refuse_command(request);
  deadline_ = now + kClientTimeOut;
  auto* const received = std::get_if<SdoBlockDownload>(&block_);
  const SdoBlockStep step = received != nullptr ? received->receive(request)
                                                : std::get<SdoBlockUpload>(block_).receive(request);
  if (step.abort != AbortCode::none) {
    end_transfer();
    return send_abort(object_, step.abort);
  }
  if (step.is_complete) conclude_block(now);
}

void SdoServer::conclude_block(DriveTime now) {
  const auto* const received = std::get_if<SdoBlockDownload>(&block_);
  if (received == nullptr) return end_transfer();
  const std::vector<std::uint8_t> data(received->data().begin(), received->data().end());
  end_transfer();
  download(
      {.object = object_, .transfer = Transfer::download, .response = kBlockDownloadEndResponse},
      data, now);
}

bool SdoServer::check_segment(const Frame& request, Transfer expected) {
  if (transfer_ != expected) {
    refuse_command(request);
    return false;
  }
  if (((request.data[0] & kToggle) != 0) != toggle_) {
    end_transfer();
    send_abort(object_, AbortCode::toggle_bit_not_alternated);
    return false;
  }
  return true;
}

void SdoServer::continue_transfer(DriveTime now) {
  toggle_ = !toggle_;
  deadline_ = now + kClientTimeOut;
}

void SdoServer::end_transfer() {
  transfer_ = Transfer::none;
  block_ = std::monostate{};
  data_.clear();
  toggle_ = false;
}

/// @return the object that an abort of this request names: 0000h if there is none.
ObjectAddress SdoServer::object_of(const Frame& request) const {
  if (names_object(request)) return multiplexer_of(request);
  return transfer_ == Transfer::none ? ObjectAddress{} : object_;
}

void SdoServer::send_abort(ObjectAddress object, AbortCode code) {
  ++counters_.aborts;
  send(kAbort, object, sdo_bytes_of(wire_code(code)));
}

/// @param data at most 4 bytes
void SdoServer::send(std::uint8_t command, ObjectAddress object,
                     std::span<const std::uint8_t> data) {
  Frame response{.id = kSdoResponseId + node_id_, .size = kMostData};
  response.data[0] = command;
  response.data[1] = static_cast<std::uint8_t>(object.index & 0xFFU);
  response.data[2] = static_cast<std::uint8_t>(object.index >> 8U);
  response.data[3] = object.subindex;
  std::ranges::copy(data, response.data.begin() + kExpeditedData);
  host_.send(response);
}

}  // namespace vdrive::canopen
